#pragma once
// The same measurement at other points: what a gain is judged by must not have been fitted. Pure.

#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

// Every point moves a share of the way to its neighbour within its line (the one after it, or, for
// the last, the one before); returns to zero stay. So lines run the way they ran, every point is
// inside the hull of those visited, and no two repeats share one: the shares follow the golden
// ratio. repeat: 1, 2, ...; 0 gives the trajectory as it is. Rows whose neighbour is at another
// force move too: only positions change.
Trajectory fresh_points(Trajectory trajectory, int repeat);

}  // namespace driftwise::application
