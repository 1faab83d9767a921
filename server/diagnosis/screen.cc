#include "server/diagnosis/screen.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/held_out_gain.h"
#include "server/diagnosis/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWrongRow = 8, kAgree = 4;  // robust standard deviations
constexpr double kMostWrongRows = 0.02;
constexpr double kNoiseChangeGain = 30;
constexpr Eigen::Index kFewestEachSide = 25;

}  // namespace

std::vector<OutlierRow> outlier_rows(const Problem& problem) {
  std::vector<OutlierRow> found;
  const auto& learn = problem.learn;
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd left = residuals(problem, output, problem.base_columns);
    const auto at = [&](std::size_t i) { return left[static_cast<Eigen::Index>(learn[i])]; };
    std::vector<double> apart(learn.size(), 0), across(learn.size(), 0);
    for (std::size_t i = 1; i + 1 < learn.size(); ++i) {
      apart[i] = at(i) - (at(i - 1) + at(i + 1)) / 2;
      across[i] = at(i + 1) - at(i - 1);
    }
    const double sd = robust_sd(apart), sd_across = robust_sd(across);
    if (!(sd > 0)) continue;
    for (std::size_t i = 1; i + 1 < learn.size(); ++i)
      if (std::abs(apart[i]) > kWrongRow * sd && std::abs(across[i]) < kAgree * sd_across)
        found.push_back({learn[i], output.channel.symbol, std::abs(apart[i]) / sd});
  }
  if (static_cast<double>(found.size()) > kMostWrongRows * static_cast<double>(learn.size()))
    return {};
  std::ranges::stable_sort(found, {}, &OutlierRow::row);
  return found;
}

std::vector<NoiseChange> noise_changes(const Ground& ground) {
  std::vector<NoiseChange> found;
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const Eigen::VectorXd left =
        ground.space(ground.best_shape(o)).left_over(ground.series().col(o));
    const Eigen::Index n = left.size();
    // the fourth moment of what is left says how far its squares spread: 3 where it is normal
    const double mean_square = left.squaredNorm() / static_cast<double>(n);
    const double kurtosis = left.array().pow(4).mean() / (mean_square * mean_square);
    const double spread = std::max((kurtosis - 1) / 2, 1.0);
    NoiseChange best{static_cast<std::size_t>(o), 0, 1, 0};
    double before = 0;
    for (Eigen::Index k = 1; k + kFewestEachSide <= n; ++k) {
      before += left[k - 1] * left[k - 1];
      if (k < kFewestEachSide) continue;
      const auto n1 = static_cast<double>(k), n2 = static_cast<double>(n - k);
      const double v1 = before / n1, v2 = (left.squaredNorm() - before) / n2;
      const double gain =
          (static_cast<double>(n) * std::log(mean_square) - n1 * std::log(v1) - n2 * std::log(v2)) /
          spread;
      if (gain > best.gain) best = {static_cast<std::size_t>(o), k, std::sqrt(v2 / v1), gain};
    }
    if (best.gain > kNoiseChangeGain) found.push_back(best);
  }
  return found;
}

}  // namespace driftwise::diagnosis
