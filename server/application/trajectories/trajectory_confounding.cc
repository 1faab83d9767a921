#include "server/application/trajectories/trajectory_confounding.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace driftwise::application {
namespace {

constexpr std::size_t kMostOrders = 7;  // 5040 orders: some milliseconds

struct Block {  // calibration rows of one force, one after another
  double force_n = 0;
  std::vector<double> time_s;
};

std::vector<Block> blocks_of(const Trajectory& trajectory, std::span<const double> time_s) {
  std::vector<Block> blocks;
  bool goes_on = false;
  for (std::size_t row = 0; row < trajectory.points.size(); ++row) {
    const auto& point = trajectory.points[row];
    if (point.set != PointSet::calibration || !point.force_n) {
      goes_on = false;
      continue;
    }
    if (!goes_on || blocks.back().force_n != *point.force_n) blocks.push_back({*point.force_n, {}});
    goes_on = true;
    blocks.back().time_s.push_back(time_s[row]);
  }
  return blocks;
}

double correlation_of(const std::vector<Block>& blocks, const std::vector<double>& forces_n) {
  std::vector<double> force, time;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    force.insert(force.end(), blocks[i].time_s.size(), forces_n[i]);
    time.insert(time.end(), blocks[i].time_s.begin(), blocks[i].time_s.end());
  }
  return correlation(force, time);
}

}  // namespace

double correlation(std::span<const double> a, std::span<const double> b) {
  const auto n = static_cast<double>(a.size());
  if (a.empty()) return 0;
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

bool ForceTrend::confounded() const { return std::abs(correlation) >= kConfounded; }

std::string ForceTrend::sentence() const {
  const double inflation = 1 / std::sqrt(std::max(1e-12, 1 - correlation * correlation));
  std::string text = fmt::format(
      "force_N {} along with time (correlation {:+.2f} over {} calibration rows, which makes the "
      "standard error of its coefficient {:.1f} times as large): while the room warms, a fit would "
      "take warming for force",
      correlation > 0 ? "rises" : "falls", correlation, rows, inflation);
  if (!better_n.empty())
    text += fmt::format(". Measure the forces in another order: {:g} N has {:+.2f}",
                        fmt::join(better_n, ", "), better_correlation);
  return text;
}

ForceTrend force_trend(const Trajectory& trajectory, std::span<const double> time_s) {
  const auto blocks = blocks_of(trajectory, time_s);
  ForceTrend trend;
  for (const auto& block : blocks) {
    trend.order_n.push_back(block.force_n);
    trend.rows += block.time_s.size();
  }
  trend.correlation = correlation_of(blocks, trend.order_n);
  if (blocks.size() > kMostOrders || !trend.confounded()) return trend;
  auto order = trend.order_n;
  std::ranges::sort(order);
  double least = std::abs(trend.correlation);
  do {
    const double r = correlation_of(blocks, order);
    if (std::abs(r) < least - 1e-9) {
      least = std::abs(r);
      trend.better_n = order;
      trend.better_correlation = r;
    }
  } while (std::ranges::next_permutation(order).found);
  return trend;
}

}  // namespace driftwise::application
