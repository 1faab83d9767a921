#pragma once
// Seeded noise for these tests.

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace driftwise::tests {

inline std::vector<double> white_noise(std::size_t count, double sd, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0, sd);
  std::vector<double> values(count);
  for (double& value : values) value = normal(generator);
  return values;
}

inline std::vector<double> random_walk(std::size_t count, double step, unsigned seed) {
  auto values = white_noise(count, step, seed);
  for (std::size_t i = 1; i < count; ++i) values[i] += values[i - 1];
  return values;
}

// Exponential correlation over so many values, of this standard deviation.
inline std::vector<double> slow_noise(std::size_t count, double sd, double correlation,
                                      unsigned seed) {
  const double phi = std::exp(-1 / correlation);
  auto values = white_noise(count, sd * std::sqrt(1 - phi * phi), seed);
  values[0] *= 1 / std::sqrt(1 - phi * phi);
  for (std::size_t i = 1; i < count; ++i) values[i] += phi * values[i - 1];
  return values;
}

inline std::vector<double> times(std::size_t count, double interval_s) {
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<double>(i) * interval_s;
  return out;
}

}  // namespace driftwise::tests
