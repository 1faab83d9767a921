#include "server/core/utc_map.h"

#include <algorithm>

namespace driftwise {

Nanoseconds UtcMap::offset_at(CellTime instant) const {
  const auto after =
      std::upper_bound(stretches_.begin(), stretches_.end(), instant,
                       [](CellTime at, const UtcStretch& stretch) { return at < stretch.from; });
  return after == stretches_.begin() ? Nanoseconds(0) : std::prev(after)->offset;
}

CellTime UtcMap::cell_time(UtcTime utc) const {
  CellTime end{INT64_MAX};  // of the stretch looked at
  for (auto stretch = stretches_.rbegin(); stretch != stretches_.rend(); ++stretch) {
    const CellTime there{utc.ns - stretch->offset.count()};
    if (there >= stretch->from) return std::min(there, end);
    end = stretch->from;
  }
  return std::min(CellTime{utc.ns}, end);
}

}  // namespace driftwise
