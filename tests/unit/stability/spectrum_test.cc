#include "server/stability/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/stability/noise.h"

namespace driftwise::tests {
namespace {

using stability::power_spectrum;

// One-sided density of white noise: 2 sd^2 interval, the same at every frequency.
TEST(PowerSpectrum, OfWhiteNoiseIsFlatAtItsClosedForm) {
  const auto spectrum = power_spectrum(white_noise(100'000, 3, 1), 0.25);
  double mean = 0;
  for (const auto& point : spectrum) mean += point.density / static_cast<double>(spectrum.size());
  EXPECT_NEAR(mean, 2 * 9 * 0.25, 0.02 * 4.5);
}

// Parseval: the integral over all frequencies is the variance.
TEST(PowerSpectrum, IntegratesToTheVariance) {
  const auto spectrum = power_spectrum(white_noise(50'000, 1.7, 2), 2);
  double integral = 0;
  for (const auto& point : spectrum)
    integral += point.density * (spectrum[1].frequency_hz - spectrum[0].frequency_hz);
  EXPECT_NEAR(integral, 1.7 * 1.7, 0.03 * 1.7 * 1.7);
}

TEST(PowerSpectrum, FindsASineWithItsPower) {
  constexpr double kFrequency_hz = 0.125, kAmplitude = 4;
  std::vector<double> values(8192);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] =
        100 + kAmplitude * std::sin(2 * std::numbers::pi * kFrequency_hz * static_cast<double>(i));
  const auto spectrum = power_spectrum(values, 1);
  double power = 0, best = 0, at_hz = 0;
  const double width = spectrum[1].frequency_hz - spectrum[0].frequency_hz;
  for (const auto& point : spectrum) {
    power += point.density * width;
    if (point.density > best) best = point.density, at_hz = point.frequency_hz;
  }
  EXPECT_NEAR(at_hz, kFrequency_hz, 1e-9);
  EXPECT_NEAR(power, kAmplitude * kAmplitude / 2, 1e-6);
}

TEST(PowerSpectrum, OfTooFewValuesIsEmpty) {
  EXPECT_TRUE(power_spectrum(std::vector<double>(15, 1), 1).empty());
}

// Of a unit pulse every frequency has the size 1, and two transforms turn the order round.
TEST(Transform, OfAPulseIsOneEverywhere) {
  std::vector<std::complex<double>> values(16, 0);
  values[3] = 1;
  stability::transform(values);
  for (const auto& value : values) EXPECT_NEAR(std::abs(value), 1, 1e-12);
  stability::transform(values);
  EXPECT_NEAR(values[13].real(), 16, 1e-12);
}

}  // namespace
}  // namespace driftwise::tests
