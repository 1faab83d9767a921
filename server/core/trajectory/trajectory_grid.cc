#include "server/core/trajectory/trajectory_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "server/core/reasons.h"

namespace driftwise {
namespace {

constexpr std::int64_t kMostPoints = 1'000'000;

std::string points_text(double points) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", points);
  return text;
}

double to_whole_pm(double mm) { return std::round(mm * 1e9) / 1e9; }

tl::unexpected<Error> bad_plan(const std::string& message) {
  return fail(ErrorCode::invalid_argument, reasons::kBadPlan, message);
}

Result<void> check_ranges(const Trajectory& trajectory, const PlanBlock& block) {
  if (block.ranges.size() != trajectory.coordinates.size())
    return bad_plan("found " + std::to_string(block.ranges.size()) +
                    " ranges, expected one for each of " +
                    std::to_string(trajectory.coordinates.size()) + " coordinates");
  for (std::size_t i = 0; i < block.ranges.size(); ++i) {
    const auto& range = block.ranges[i];
    const auto name = trajectory.coordinates[i].name();
    if (!std::isfinite(range.from_mm) || !std::isfinite(range.to_mm) || range.to_mm < range.from_mm)
      return bad_plan(name +
                      ": found a range that does not rise, expected FROM:TO:STEP such as "
                      "0:2.5:0.5");
    if (block.scattered == 0 && (!std::isfinite(range.step_mm) || range.step_mm <= 0))
      return bad_plan(name +
                      ": found a step that is not above 0, expected FROM:TO:STEP such as "
                      "0:2.5:0.5");
  }
  return {};
}

TrajectoryPoint point_of(const PlanBlock& block, std::int64_t line, std::vector<double> target_mm) {
  TrajectoryPoint point;
  point.target = std::move(target_mm);
  point.set = block.set;
  point.line = line;
  point.force_n = block.force_n;
  point.dwell_s = block.dwell_s;
  return point;
}

Result<void> append_lines(Trajectory& trajectory, const PlanBlock& block, std::int64_t line) {
  const std::size_t n = block.ranges.size();
  double points = 1, lines = 1;
  for (std::size_t i = 0; i < n; ++i) {
    const double levels = block.ranges[i].count();
    points *= levels;
    if (i + 1 < n) lines *= levels;
  }
  if (!(points + lines <= static_cast<double>(kMostPoints)))
    return bad_plan("found a grid of " + points_text(points) +
                    " points, expected a million at most: take a larger step");
  std::vector<std::int64_t> at(n, 0);
  for (;; ++line) {
    for (std::int64_t i = 0; i < block.ranges[n - 1].levels(); ++i) {
      at[n - 1] = i;
      std::vector<double> target;
      for (std::size_t k = 0; k < n; ++k) target.push_back(block.ranges[k].level_mm(at[k]));
      trajectory.points.push_back(point_of(block, line, std::move(target)));
    }
    if (block.zeros) {
      trajectory.points.push_back(point_of(block, line, std::vector<double>(n, 0.0)));
      trajectory.points.back().zero = true;
    }
    std::size_t k = n - 1;  // the next line: like an odometer, the last but one turns fastest
    while (k > 0 && ++at[k - 1] == block.ranges[k - 1].levels()) at[--k] = 0;
    if (k == 0) return {};
  }
}

// One coordinate of a scattered point, away from every level that the plan holds already.
double scattered_mm(std::mt19937_64& random, const GridRange& range,
                    const std::vector<double>& levels_mm) {
  constexpr double kApart_mm = 1e-4;
  constexpr int kTries = 1000;
  double mm = range.from_mm;
  for (int i = 0; i < kTries; ++i) {
    const double share = static_cast<double>(random() >> 11) * 0x1.0p-53;
    mm = std::round((range.from_mm + share * (range.to_mm - range.from_mm)) * 1e4) / 1e4;
    const auto next = std::ranges::lower_bound(levels_mm, mm - kApart_mm / 2);
    if (next == levels_mm.end() || *next > mm + kApart_mm / 2) break;
  }
  return mm;
}

void append_scattered(Trajectory& trajectory, const PlanBlock& block, std::int64_t line) {
  constexpr std::int64_t kLine = 10;
  std::vector<std::vector<double>> levels(block.ranges.size());
  for (const auto& point : trajectory.points)
    for (std::size_t k = 0; k < levels.size(); ++k) levels[k].push_back(point.target[k]);
  for (auto& of_coordinate : levels) std::ranges::sort(of_coordinate);
  std::mt19937_64 random(block.seed);
  for (std::int64_t i = 0; i < block.scattered; ++i) {
    std::vector<double> target;
    for (std::size_t k = 0; k < levels.size(); ++k)
      target.push_back(scattered_mm(random, block.ranges[k], levels[k]));
    trajectory.points.push_back(point_of(block, line + i / kLine, std::move(target)));
  }
}

}  // namespace

double GridRange::count() const { return std::floor((to_mm - from_mm) / step_mm + 1e-6) + 1; }

std::int64_t GridRange::levels() const { return static_cast<std::int64_t>(count()); }

double GridRange::level_mm(std::int64_t i) const {
  return to_whole_pm(from_mm + static_cast<double>(i) * step_mm);
}

Result<void> append_block(Trajectory& trajectory, const PlanBlock& block) {
  if (auto ok = check_ranges(trajectory, block); !ok) return ok;
  if (block.scattered < 0 || block.scattered > kMostPoints)
    return bad_plan("found " + std::to_string(block.scattered) +
                    " scattered points, expected 1 to 1000000");
  const std::int64_t line = trajectory.points.empty() ? 1 : trajectory.points.back().line + 1;
  if (block.scattered == 0) return append_lines(trajectory, block, line);
  append_scattered(trajectory, block, line);
  return {};
}

}  // namespace driftwise
