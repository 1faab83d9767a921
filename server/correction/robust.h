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

// Standard deviation of a normal distribution, by the deviation that three quarters of the values
// do not exceed: 1.1503 sigmas. Less than a quarter of wrong values do not move it, and values at
// two places do not make it 0 or twice as large by chance.
inline double sigma_of_most(std::vector<double> values) {
  if (values.empty()) return 0;
  const double median = median_of(values);
  for (double& value : values) value = std::abs(value - median);
  const auto most = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * 3 / 4);
  std::nth_element(values.begin(), most, values.end());
  return *most / 1.1503;
}

// Median of the means of all pairs (Hodges and Lehmann, 1963). Single wrong values do not move it,
// and values at two places leave it between them, where a median is at one of the two: a servo
// comes to rest at +-30 nm. Of more than 1000 values every second, third, ... is taken.
inline double centre_of(const std::vector<double>& values) {
  constexpr std::size_t kMost = 1000;
  const std::size_t step = 1 + (values.size() - std::min<std::size_t>(1, values.size())) / kMost;
  std::vector<double> means;
  for (std::size_t i = 0; i < values.size(); i += step)
    for (std::size_t j = i; j < values.size(); j += step)
      means.push_back(0.5 * (values[i] + values[j]));
  return median_of(std::move(means));
}

// Standard deviation without the values beyond five times it. Two places (+-30 nm and a mean of
// three of them) have a robust sigma a fifth above their standard deviation, or near 0.
inline double sigma_without_far_off(std::vector<double> values) {
  constexpr double kFarOff = 5;
  const auto mean_of = [&values](auto of) {
    double sum = 0;
    for (const double value : values) sum += of(value);
    return values.empty() ? 0 : sum / static_cast<double>(values.size());
  };
  double mean = 0, sigma = 0;
  for (int pass = 0; pass < 2; ++pass) {
    mean = mean_of([](double value) { return value; });
    sigma = std::sqrt(mean_of([mean](double value) { return (value - mean) * (value - mean); }));
    std::erase_if(values,
                  [mean, sigma](double value) { return std::abs(value - mean) > kFarOff * sigma; });
  }
  return sigma;
}

}  // namespace driftwise::correction
