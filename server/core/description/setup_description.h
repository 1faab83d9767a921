#pragma once
// [[setup]] of a cell file: a named choice of instruments. A run states its set-up; the instruments
// that the set-up does not name are neither read nor required.

#include <optional>
#include <string>
#include <vector>

#include "server/core/channel.h"

namespace driftwise {

// One coordinate that a set-up measures.
struct SetupCoordinate {
  Channel channel;     // x_mm
  std::string device;  // id of the instrument that gives it
  // Rectification: coordinate = scale * reading + offset, in the channel's unit.
  double scale = 1, offset = 0;
  // Range of the rectified coordinate, in the channel's unit. Outside it the coordinate is not
  // measured: a state, not a failure. None: it must be there.
  std::optional<double> min, max;
  bool may_be_missing() const { return min.has_value() || max.has_value(); }
};

struct SetupDescription {
  std::string name;  // "tilts"
  std::string description;
  std::vector<SetupCoordinate> coordinates;  // at least one
};

}  // namespace driftwise
