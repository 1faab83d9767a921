#include "server/calibration/report/held_out_figure.h"

#include <cmath>
#include <map>

#include "server/calibration/linear/tail.h"

namespace driftwise::calibration {
namespace {

struct Range {
  double low = 0, high = 0;
};

// 90 %: the jackknife over the folds on the logarithm of the square of a figure.
template <class Figure>
Range jackknife(const std::vector<ErrorSums>& folds, const ErrorSums& all, Figure figure) {
  const double whole = figure(error_figures(all));
  const auto count = static_cast<double>(folds.size());
  std::vector<double> left_out;
  double mean = 0;
  for (const auto& fold : folds) {
    left_out.push_back(2 * std::log(figure(error_figures(all - fold))));
    mean += left_out.back() / count;
  }
  double spread = 0;
  for (const double one : left_out) spread += (one - mean) * (one - mean);
  const double half = t_quantile(0.95, count - 1) * std::sqrt(spread * (count - 1) / count);
  if (!std::isfinite(half)) return {whole, whole};
  return {whole * std::exp(-half / 2), whole * std::exp(half / 2)};
}

}  // namespace

void judge_untrained(std::span<const int> datums, const std::set<int>& trained,
                     Eigen::Ref<Eigen::VectorXd> errors) {
  struct Rows {
    double sum = 0, count = 0;
  };
  std::map<int, Rows> untrained;
  for (Eigen::Index row = 0; row < errors.size(); ++row) {
    const int datum = datums[static_cast<std::size_t>(row)];
    if (trained.contains(datum)) continue;
    Rows& rows = untrained[datum];
    if (!std::isfinite(errors[row])) continue;
    rows.sum += errors[row];
    rows.count += 1;
  }
  if (untrained.empty()) return;
  for (Eigen::Index row = 0; row < errors.size(); ++row) {
    const auto at = untrained.find(datums[static_cast<std::size_t>(row)]);
    if (at == untrained.end()) continue;
    const auto [sum, count] = at->second;
    errors[row] = count > 1 ? (errors[row] - sum / count) * std::sqrt(count / (count - 1)) : NAN;
  }
}

HeldOut held_out_figure(const std::vector<ErrorSums>& folds) {
  ErrorSums all;
  for (const auto& fold : folds) all += fold;
  if (!(all.squares > 0)) return {};
  HeldOut result{.figures = error_figures(all), .folds = static_cast<int>(folds.size())};
  const Range a90 = jackknife(folds, all, [](const auto& figures) { return figures.a90; });
  const Range u90 = jackknife(folds, all, [](const auto& figures) { return figures.u90; });
  result.low = a90.low;
  result.high = a90.high;
  result.u90_low = u90.low;
  result.u90_high = u90.high;
  return result;
}

}  // namespace driftwise::calibration
