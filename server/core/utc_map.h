#pragma once
// UTC of instants of cell time. Cell time never steps; the computer's wall clock may be set. Each
// time that it is, a new stretch of the map begins: instants before it keep the UTC that they had.

#include <memory>
#include <vector>

#include "server/core/cell_time.h"

namespace driftwise {

struct UtcTime {
  std::int64_t ns = 0;  // since 1970-01-01T00:00:00Z, without leap seconds
  auto operator<=>(const UtcTime&) const = default;
};
inline std::string to_iso8601(UtcTime time) { return to_iso8601(CellTime{time.ns}); }

// From this instant on UTC is cell time plus the offset.
struct UtcStretch {
  CellTime from;
  Nanoseconds offset{0};
};

// Without a stretch UTC is cell time.
class UtcMap {
 public:
  UtcMap() = default;
  // Ascending by `from`; instants before the first have the offset 0.
  explicit UtcMap(std::vector<UtcStretch> stretches) : stretches_(std::move(stretches)) {}

  Nanoseconds offset_at(CellTime instant) const;
  UtcTime utc(CellTime instant) const { return {instant.utc_ns + offset_at(instant).count()}; }
  // The latest instant that had this UTC. A UTC that a step forward left out: the instant of the
  // step.
  CellTime cell_time(UtcTime utc) const;

 private:
  std::vector<UtcStretch> stretches_;
};

}  // namespace driftwise
