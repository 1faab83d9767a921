#pragma once
// Which cells have fallen silent, and whose record has become another one. Pure; the caller states
// the time.
//
//   cell.silent    no sign of life for silent_after_s; over with the next one
//   chain.changed  a head with a number below one that was told before, or with the same number and
//                  another hash: the record was replaced, restored or computed anew; over at once,
//                  a person looks

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "server/core/records/notify_records.h"

namespace driftwise::watchdog {

class WatchBook {
 public:
  static constexpr std::size_t kMostCells = 256;  // a further one is not watched

  explicit WatchBook(double silent_after_s) : silent_after_s_(silent_after_s) {}

  // A cell that is expected: silent when it does not speak from now on.
  void expect(const std::string& cell, double now_s, UtcTime now);
  // now_s: monotonic. Alarms that began or are over.
  std::vector<AlarmNews> take(const LifeSign& sign, const ChainHead& known, double now_s,
                              UtcTime now);
  std::vector<AlarmNews> look(double now_s, UtcTime now);
  bool has_room_for(const std::string& cell) const {
    return cells_.contains(cell) || cells_.size() < kMostCells;
  }

 private:
  struct Cell {
    double heard_s = 0;
    UtcTime heard;
    bool ever = false;    // since this program's start
    AlarmRecord silence;  // id 0: it is not silent
  };
  AlarmNews raise(const std::string& cell, const char* kind, std::string message, UtcTime now);

  double silent_after_s_;
  std::int64_t last_id_ = 0;
  std::map<std::string, Cell> cells_;
};

}  // namespace driftwise::watchdog
