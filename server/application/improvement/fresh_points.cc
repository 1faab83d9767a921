#include "server/application/improvement/fresh_points.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace driftwise::application {
namespace {

struct Neighbour {
  std::size_t at = 0;
  bool is_ahead = true;
};

// The nearest point that is elsewhere: after this one, else before it; of its line, else of the
// plan.
std::optional<Neighbour> neighbour_of(const std::vector<TrajectoryPoint>& points, std::size_t i) {
  for (const bool of_line : {true, false}) {
    const auto is_one = [&](std::size_t j) {
      return !points[j].zero && points[j].target != points[i].target &&
             (!of_line || points[j].line == points[i].line);
    };
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      if (is_one(j)) return Neighbour{j, true};
      if (of_line && points[j].line != points[i].line) break;
    }
    for (std::size_t j = i; j-- > 0;) {
      if (is_one(j)) return Neighbour{j, false};
      if (of_line && points[j].line != points[i].line) break;
    }
  }
  return std::nullopt;
}

}  // namespace

Trajectory fresh_points(Trajectory trajectory, int repeat) {
  if (repeat <= 0) return trajectory;
  // Fractional parts of multiples of the golden ratio fill an interval as evenly as can be; kept
  // away from both ends, where a point would be one that was visited.
  const double golden = std::numbers::phi * repeat;
  const double share = 0.1 + 0.8 * (golden - std::floor(golden));
  const auto before = trajectory.points;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].zero) continue;
    const auto neighbour = neighbour_of(before, i);
    if (!neighbour) continue;
    // The last of a line moves back over the gap that the others moved into.
    const double part = neighbour->is_ahead ? share : (1 - share) / 2;
    for (std::size_t axis = 0; axis < before[i].target.size(); ++axis)
      trajectory.points[i].target[axis] +=
          part * (before[neighbour->at].target[axis] - before[i].target[axis]);
  }
  return trajectory;
}

}  // namespace driftwise::application
