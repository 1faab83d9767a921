#include "server/stability/spectrum.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace driftwise::stability {

void transform(std::vector<std::complex<double>>& values) {
  const std::size_t size = values.size();
  for (std::size_t i = 1, j = 0; i < size; ++i) {
    std::size_t bit = size >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (std::size_t length = 2; length <= size; length *= 2) {
    const double angle = -2 * std::numbers::pi / static_cast<double>(length);
    for (std::size_t start = 0; start < size; start += length)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const auto turn = std::polar(1.0, angle * static_cast<double>(k));
        const auto even = values[start + k];
        const auto odd = turn * values[start + k + length / 2];
        values[start + k] = even + odd;
        values[start + k + length / 2] = even - odd;
      }
  }
}

std::vector<SpectrumPoint> power_spectrum(std::span<const double> values, double interval_s) {
  constexpr std::size_t kFewest = 16, kLongest = 4096;
  if (values.size() < kFewest || !(interval_s > 0)) return {};
  std::size_t length = 8;
  // Four segments that overlap by half cover 2.5 lengths.
  while (2 * length <= kLongest && 5 * length <= values.size()) length *= 2;
  std::vector<double> window(length);
  double power = 0;
  for (std::size_t i = 0; i < length; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) /
                                     static_cast<double>(length));
    power += window[i] * window[i];
  }
  std::vector<double> sums(length / 2 + 1, 0);
  std::size_t segments = 0;
  std::vector<std::complex<double>> segment(length);
  for (std::size_t start = 0; start + length <= values.size(); start += length / 2, ++segments) {
    double mean = 0;
    for (std::size_t i = 0; i < length; ++i)
      mean += values[start + i] / static_cast<double>(length);
    for (std::size_t i = 0; i < length; ++i) segment[i] = window[i] * (values[start + i] - mean);
    transform(segment);
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += std::norm(segment[k]);
  }
  std::vector<SpectrumPoint> points;
  for (std::size_t k = 1; k < sums.size(); ++k) {
    const double sides = k == length / 2 ? 1 : 2;
    points.push_back({static_cast<double>(k) / (static_cast<double>(length) * interval_s),
                      sides * interval_s * sums[k] / (power * static_cast<double>(segments))});
  }
  return points;
}

}  // namespace driftwise::stability
