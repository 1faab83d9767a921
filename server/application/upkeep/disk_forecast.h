#pragma once
// Forecast of a disk that fills up, from the growth of the record over the last day. Pure.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise::application {

class DiskForecast {
 public:
  static constexpr double kWindow_s = 86'400;   // growth is taken over the last day,
  static constexpr double kShortest_s = 3'600;  // and never from less than an hour
  static constexpr double kWarn_days = 14;

  // record_bytes: the database with its log; free_bytes: of its disk.
  void take(CellTime at, std::int64_t record_bytes, std::int64_t free_bytes);

  // Days until the disk is full at this growth; none: too little is known, or nothing grows.
  std::optional<double> days() const;
  double bytes_per_hour() const;  // 0: not known
  // "the disk of cell.db is full in 9 days: 260 MB are free, the record grows by 1.2 MB an hour;
  // make room, or move backups away". Empty: more than kWarn_days are left.
  std::string warning(const std::string& path) const;

 private:
  struct Sample {
    CellTime at;
    std::int64_t bytes;
  };
  std::deque<Sample> samples_;
  std::int64_t free_bytes_ = 0;
};

}  // namespace driftwise::application
