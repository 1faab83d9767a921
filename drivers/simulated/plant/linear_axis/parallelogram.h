#pragma once
// Where the mirror is when the stage of a flexure parallelogram has moved: real geometry of two
// legs, no series.
//
// x along the axis, away from the interferometer; z up. A leg of length L that leans by x drops its
// upper end by e - sqrt(e^2 - x^2), e = L / (2 f): f = 0.6 for a leaf spring bent into an S, 0.5
// for a bar between pivots. Different drops tilt the stage; tilt and drop reach the beam through
// its height above the scale and the mirror's tilt.

#include "drivers/simulated/plant/linear_axis/linear_axis_parameters.h"

namespace driftwise::simulated {

struct StagePose {
  double rise_mm = 0;    // of the stage's middle against legs upright at the reference temperature
  double pitch_rad = 0;  // right end higher: positive
};

// left_k, right_k: the legs' temperatures less the reference.
StagePose stage_pose(const ParallelogramParameters& p, double stage_mm, double left_k,
                     double right_k);

// The mirror's position along the beam, mm, for the stage at stage_mm (at the height of the scale).
double mirror_mm(const ParallelogramParameters& p, double stage_mm, const StagePose& pose);

}  // namespace driftwise::simulated
