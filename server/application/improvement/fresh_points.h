#pragma once
// The same measurement at other points: what a gain is judged by must not have been fitted. Pure.

#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// Every point moves a share of the way to its neighbour: the nearest one elsewhere that comes after
// it in its line, or, for the last, before it; where its line has no other place, in the plan.
// Returns to zero stay, and so does a plan of one place. So lines run the way they ran, every point
// is inside the hull of those visited, and no two repeats share one: the shares follow the golden
// ratio. repeat: 1, 2, ...; 0 gives the trajectory as it is. Rows whose neighbour is at another
// force move too: only positions change.
Trajectory fresh_points(Trajectory trajectory, int repeat);

}  // namespace driftwise::application
