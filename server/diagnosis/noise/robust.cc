#include "server/diagnosis/noise/robust.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "server/calibration/linear/tail.h"

namespace driftwise::diagnosis {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double robust_sd(std::vector<double> values) {
  constexpr double kMadToSd = 1.4826;
  for (auto& value : values) value = std::abs(value);
  return kMadToSd * median(std::move(values));
}

double StudentLaw::beyond(double value) const {
  double chance = 0;
  for (std::size_t f = 0; f < kFreedoms.size(); ++f)
    if (scale_[f] > 0)
      chance += weight_[f] * calibration::t_two_sided_p(value / scale_[f], kFreedoms[f]);
  return chance;
}

StudentLaw student_law(const std::vector<double>& values, double least) {
  constexpr int kRounds = 40;
  StudentLaw law;
  const auto n = static_cast<double>(values.size());
  const double floor = std::max(least * least, 1e-300);
  auto& ln = law.weight_;
  for (std::size_t f = 0; f < StudentLaw::kFreedoms.size(); ++f) {
    const double freedom = StudentLaw::kFreedoms[f];
    double square = std::max(std::pow(robust_sd(values), 2), floor);
    for (int round = 0; round < kRounds; ++round) {  // expectation and maximisation
      double sum = 0;
      for (const double value : values)
        sum += (freedom + 1) * value * value / (freedom + value * value / square);
      square = std::max(sum / std::max(n, 1.0), floor);
    }
    law.scale_[f] = std::sqrt(square);
    ln[f] = n * (std::lgamma((freedom + 1) / 2) - std::lgamma(freedom / 2) -
                 0.5 * std::log(freedom * std::numbers::pi * square));
    for (const double value : values)
      ln[f] -= (freedom + 1) / 2 * std::log1p(value * value / (freedom * square));
  }
  const double highest = *std::ranges::max_element(ln);
  double sum = 0;
  for (double& one : ln) sum += one = std::exp(one - highest);
  for (double& one : ln) one /= sum;
  return law;
}

double chance_of_as_many(double p, std::size_t count, std::size_t all) {
  // The expected number of groups of `count`, all over: binomial coefficient times p^count.
  const auto k = static_cast<double>(count), n = static_cast<double>(all);
  if (count == 0 || count > all) return count == 0 ? 1 : 0;
  if (!(p > 0)) return 0;
  const double ln =
      std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p);
  return ln < 0 ? std::exp(ln) : 1;
}

}  // namespace driftwise::diagnosis
