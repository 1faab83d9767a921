#include "server/diagnosis/noise/shape_between.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr int kMostRounds = 8;      // each halves the steps
constexpr double kAsLikely = 0.5;   // of 2 ln L, between neighbours
constexpr double kRatioStep = 1.8;  // half of the grid's, as a factor

double half_step_of_times(const std::vector<NoiseShape>& grid) {
  for (std::size_t s = 2; s < grid.size(); ++s)
    if (grid[s - 1].slow_ratio > 0 && grid[s].slow_ratio == grid[s - 1].slow_ratio)
      return std::sqrt(grid[s].tau_s / grid[s - 1].tau_s);
  return 1;
}

}  // namespace

std::vector<NoiseShape> shapes_between(const Timeline& timeline,
                                       const std::vector<NoiseShape>& grid, const Ground& on_grid,
                                       const SoftBase& base, const Eigen::MatrixXd& series,
                                       const std::function<bool()>& tick) {
  std::vector<NoiseShape> chosen;
  for (Eigen::Index o = 0; o < on_grid.outputs(); ++o) chosen.push_back(on_grid.noise(o));
  double of_time = half_step_of_times(grid), of_ratio = kRatioStep;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<NoiseShape> shapes;
    const auto add = [&](const NoiseShape& shape) {
      if (std::ranges::find(shapes, shape) == shapes.end()) shapes.push_back(shape);
    };
    for (const auto& shape : chosen) {
      add(shape);
      if (shape.slow_ratio == 0) continue;
      for (const double ratio : {1 / of_ratio, 1.0, of_ratio})
        for (const double time : {1 / of_time, 1.0, of_time})
          add({shape.slow_ratio * ratio, shape.tau_s * time});
    }
    const auto is_white = [](const NoiseShape& shape) { return shape.slow_ratio == 0; };
    if (std::ranges::all_of(chosen, is_white) || (tick && !tick())) return chosen;
    const Ground ground(timeline, shapes, base, series, tick);
    if (ground.shape_count() < shapes.size()) return chosen;
    double largest = 0;
    for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
      const auto& before = chosen[static_cast<std::size_t>(o)];
      const auto near = [&](const NoiseShape& shape) {
        return std::abs(std::log(shape.tau_s / before.tau_s)) < 1.5 * std::log(of_time) &&
               std::abs(std::log(shape.slow_ratio / before.slow_ratio)) < 1.5 * std::log(of_ratio);
      };
      for (std::size_t s = 0; s < shapes.size(); ++s)
        if (before.slow_ratio > 0 && shapes[s].slow_ratio > 0 && near(shapes[s]))
          largest = std::max(largest, std::abs(ground.worse_by(s, o)));
    }
    for (Eigen::Index o = 0; o < ground.outputs(); ++o)
      chosen[static_cast<std::size_t>(o)] = ground.noise(o);
    if (largest < kAsLikely) return chosen;
    of_time = std::sqrt(of_time);
    of_ratio = std::sqrt(of_ratio);
  }
  return chosen;
}

}  // namespace driftwise::diagnosis
