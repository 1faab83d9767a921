#pragma once
// A trajectory: the points to visit, in order. Text form: docs/formats.md; parsed in
// server/formats.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise {

struct TrajectoryPoint {
  // One per coordinate of Trajectory::coordinates, in its order and unit: mm, arcsec of rotations.
  std::vector<double> target;
  PointSet set = PointSet::calibration;
  std::int64_t line =
      0;  // points of one line follow one another; a queued point is repeated at its end
  bool zero = false;              // a return to zero: its closure is recorded as drift
  std::optional<double> force_n;  // a change waits for the operator or the cell's actuator
  std::optional<double> dwell_s;  // extra wait between the end of the move and the readings
};

struct Trajectory {
  // "q1_mm".. : moved to as they stand. "x_mm".. : a wanted pose, compensated by the serving model
  // when the run says so, else taken as motor coordinates by the identity model.
  std::vector<Channel> coordinates;
  std::vector<TrajectoryPoint> points;
};

}  // namespace driftwise
