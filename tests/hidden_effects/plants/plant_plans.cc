// The trajectories of plant_run.h.

#include <cmath>
#include <random>

#include "tests/hidden_effects/plants/plant_run.h"

namespace driftwise::hidden {
namespace {

TrajectoryPoint axis_point(double mm, bool validation, std::size_t number, double dwell_s) {
  TrajectoryPoint point;
  point.target = {mm};
  point.set = validation ? PointSet::validation : PointSet::calibration;
  point.line = static_cast<std::int64_t>(number / 18);
  point.dwell_s = dwell_s;
  return point;
}

}  // namespace

// 56 passes over 0, -4, -3.5, .. 4 mm at 14.3 s per point (thesis 5.2.1).
Trajectory published_axis_plan(int passes) {
  constexpr double kDwell_s = 10.5;  // and about 0.8 s of move, 1 s to settle, 2 s of readings
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}};
  for (int pass = 0; pass < passes; ++pass) {
    plan.points.push_back(axis_point(0, false, plan.points.size(), kDwell_s));
    for (int half = -8; half <= 8; ++half)
      plan.points.push_back(axis_point(half / 2.0, half % 2 != 0, plan.points.size(), kDwell_s));
  }
  return plan;
}

Trajectory varied_axis_plan(int points, std::uint64_t seed) {
  static constexpr double kDwells_s[] = {0, 3, 10, 30, 100};
  std::mt19937_64 random(seed);
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}};
  while (static_cast<int>(plan.points.size()) < points) {
    const double mm = -4 + 0.5 * static_cast<double>(random() % 17);
    const double dwell_s = kDwells_s[random() % 5];
    plan.points.push_back(axis_point(mm, random() % 3 == 0, plan.points.size(), dwell_s));
  }
  return plan;
}

Trajectory fine_axis_plan(int points, double length_mm) {
  constexpr double kGoldenShare = 0.6180339887498949;
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}};
  for (int k = 0; k < points; ++k) {
    const double turned = (k + 1) * kGoldenShare;
    const double share = turned - std::floor(turned) - 0.5;
    plan.points.push_back(axis_point(share * length_mm, k % 3 == 2, plan.points.size(), 1));
  }
  return plan;
}

// Five grids with returns to zero after each line (thesis 6.2.2), the published order of forces.
Trajectory published_micro_nano_plan() {
  struct Grid {
    bool calibration;
    double force_n;
  };
  constexpr double kDwell_s = 8;
  Trajectory plan;
  plan.coordinates = {{"q1", "mm"}, {"q2", "mm"}, {"q3", "mm"}};
  std::int64_t line = 0;
  const auto add = [&](std::vector<double> mm, const Grid& grid, bool zero) {
    TrajectoryPoint point;
    point.target = std::move(mm);
    point.set = grid.calibration ? PointSet::calibration : PointSet::validation;
    point.line = line;
    point.zero = zero;
    point.force_n = grid.force_n;
    point.dwell_s = kDwell_s;
    plan.points.push_back(std::move(point));
  };
  for (const Grid grid :
       {Grid{true, 0}, Grid{true, 2.305}, Grid{false, 0.768}, Grid{true, 1.536}}) {
    const int count = grid.calibration ? 6 : 5;
    const double first_mm = grid.calibration ? 0 : 0.25;
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j, ++line) {
        for (int k = 0; k < count; ++k)
          add({first_mm + 0.5 * i, first_mm + 0.5 * j, first_mm + 0.5 * k}, grid, false);
        add({0, 0, 0}, grid, true);
      }
  }
  return plan;
}

}  // namespace driftwise::hidden
