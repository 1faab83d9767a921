#pragma once
// Forecast of a disk that fills up: by what it lost over the last day, and by the backups that the
// schedule will still add to it. Pure.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "server/core/cell_time.h"

namespace driftwise::application {

// The database's disk at an instant.
struct DiskSample {
  CellTime at;
  std::int64_t record_bytes = 0;  // the database with its log
  std::int64_t free_bytes = 0;
  std::int64_t backup_bytes = 0;  // of the folder of backups, where it is on this disk
};

// What the schedule will still add to the same disk: one copy each every_h hours. The last one is
// there before the oldest is removed.
struct CopiesToCome {
  std::size_t count = 0;
  double every_h = 0;
};

class DiskForecast {
 public:
  static constexpr double kWindow_s = 86'400;   // growth is taken over the last day,
  static constexpr double kShortest_s = 3'600;  // and never from less than an hour
  static constexpr double kWarn_days = 14;

  void take(const DiskSample& sample, CopiesToCome copies);

  // Days until the disk is full; none: too little is known, or it does not fill.
  std::optional<double> days() const;
  // Of all but the backups: the loss of free room, or the record's growth where that is larger. 0:
  // not known.
  double bytes_per_hour() const;
  // "the disk of cell.db is full in 9 days: 260 MB are free, it fills by 1.2 MB an hour; make room,
  // or move backups to another disk". Empty: more than kWarn_days are left.
  std::string warning(const std::string& path) const;

 private:
  std::deque<DiskSample> samples_;
  CopiesToCome copies_;
};

}  // namespace driftwise::application
