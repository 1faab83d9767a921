#pragma once
// A finding of a parallel robot, named in the frame of the pose coordinates, as its motors show it:
// the simulation is of the motors, and what is accepted of a finding enters there.

#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/search/coordinate_frame.h"

namespace driftwise::diagnosis {

// The finding's outputs become the motors, each by its slopes: what it adds to them, as far as its
// columns and the baseline's say that with one number each; held-out figures. A motor shows it
// where it has at least kShownShare of what the one that has most of it has, in units of what is
// left of each. Of an error without a subject that is spread over the coordinates as one motor's
// is, the motor is the subject. index: of the finding among the named.
void say_of_motors(const CoordinateFrame& frame, const Problem& problem, const Cause& cause,
                   const Extension& extension, std::size_t index, Finding& finding);

inline constexpr double kShownShare = 0.1;

}  // namespace driftwise::diagnosis
