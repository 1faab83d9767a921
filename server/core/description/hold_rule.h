#pragma once
// A condition of the cell under which a run waits: [[hold]] of the cell file (docs/holds.md).

#include <cstdint>
#include <optional>
#include <string>

namespace driftwise {

enum class HoldAction : std::uint8_t {
  finish_point,    // the point under way is measured, then the run waits
  return_to_zero,  // ... and the axes return to zero before it waits
  stop,            // the axes are stopped at once; the row is visited again
  end_daemon,      // ... and the daemon ends in good order: the record is closed before power goes
};

struct HoldRule {
  std::string name;     // "room": unique in the cell
  std::string channel;  // "t12_degC"; kDiskFreeGb; what is compared, in its own unit
  std::string minus;    // a channel that is subtracted from it, such as a set-point; empty: none
  // Beyond them the limit is exceeded; at least one is given.
  std::optional<double> above, below;
  // Within them, for settle_s, the hold ends. Default: above and below.
  std::optional<double> release_above, release_below;
  double for_s = 0;      // the limit must be exceeded for this long
  double settle_s = 60;  // cell time
  // A value that is older is as one beyond the limit; none: the limit of its device, and for what
  // only runs read, never.
  std::optional<double> stale_s;
  HoldAction action = HoldAction::finish_point;
  // Looked at only between the first datum of a run and its end: before that the start has a check
  // of its own.
  bool only_while_measuring = false;
  bool marks = true;   // points measured while the limit was exceeded are marked as suspect
  std::string advice;  // what a person should do about it; empty: nothing to say

  static constexpr const char* kDiskFreeGb = "disk_free_GB";  // of the database's disk
};

}  // namespace driftwise
