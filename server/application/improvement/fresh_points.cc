#include "server/application/improvement/fresh_points.h"

#include <cmath>
#include <numbers>

namespace driftwise::application {

Trajectory fresh_points(Trajectory trajectory, int repeat) {
  if (repeat <= 0) return trajectory;
  // Fractional parts of multiples of the golden ratio fill an interval as evenly as can be; kept
  // away from both ends, where a point would be one that was visited.
  const double golden = std::numbers::phi * repeat;
  const double share = 0.1 + 0.8 * (golden - std::floor(golden));
  const auto before = trajectory.points;
  const auto joins = [&](std::size_t i, std::size_t j) {
    return j < before.size() && before[j].line == before[i].line && !before[j].zero;
  };
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].zero) continue;
    const std::size_t neighbour = joins(i, i + 1) ? i + 1 : i - 1;  // 0 - 1 wraps: joins() says no
    if (neighbour != i + 1 && !joins(i, neighbour)) continue;
    // The last of a line moves back over the gap that the others moved into.
    const double part = neighbour == i + 1 ? share : (1 - share) / 2;
    for (std::size_t axis = 0; axis < before[i].target.size(); ++axis)
      trajectory.points[i].target[axis] +=
          part * (before[neighbour].target[axis] - before[i].target[axis]);
  }
  return trajectory;
}

}  // namespace driftwise::application
