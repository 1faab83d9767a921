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

// A second instrument that reads a coordinate of the set-up. The set-up's own instrument measures;
// a point whose two readings differ by more than the limit fails its gate.
struct SetupConfirmation {
  Channel channel;     // rz_arcsec: one of the set-up's coordinates
  std::string device;  // id of the second instrument
  // Rectification, as of a coordinate.
  double scale = 1, offset = 0;
  double limit = 0;  // of the difference since the datum's zero, in the channel's unit; above 0
  // rz_confirmed_arcsec: what the second instrument reads, in readings and points of the set-up.
  Channel confirmed() const { return {channel.symbol + "_confirmed", channel.unit}; }
  // rz_difference_arcsec: the second reading minus the first, in points.
  Channel difference() const { return {channel.symbol + "_difference", channel.unit}; }
};

struct SetupDescription {
  std::string name;  // "tilts"
  std::string description;
  std::vector<SetupCoordinate> coordinates;           // at least one
  std::vector<SetupConfirmation> confirmations = {};  // each coordinate at most once
};

}  // namespace driftwise
