#pragma once
// Location and spread that single wrong rows do not move.

#include <algorithm>
#include <cmath>
#include <vector>

namespace driftwise::correction {

// 0 for no value. Takes a copy: the order changes.
inline double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// 1.4826 median absolute deviations: the standard deviation of a normal distribution (Rousseeuw and
// Croux, 1993).
inline double robust_sigma(std::vector<double> values) {
  const double median = median_of(values);
  for (double& value : values) value = std::abs(value - median);
  return 1.4826 * median_of(std::move(values));
}

}  // namespace driftwise::correction
