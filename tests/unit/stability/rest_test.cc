#include "server/stability/rest.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/stability/noise.h"

namespace driftwise::tests {
namespace {

using stability::rest_of;

// A body that warms up: 400 nm with a time constant of one hour, so that the rate is below
// 20 nm/h after ln(400 / 20) = 3.0 h.
stability::Samples warming(double hours, double noise_nm, unsigned seed) {
  const auto count = static_cast<std::size_t>(hours * 3600 / 10);
  stability::Samples series{times(count, 10), white_noise(count, noise_nm, seed)};
  for (std::size_t i = 0; i < count; ++i)
    series.values[i] += 400 * (1 - std::exp(-series.time_s[i] / 3600));
  return series;
}

TEST(Rest, IsWarmFromTheTimeAtWhichTheRateIsBelowTheLimit) {
  const auto verdict = rest_of(warming(8, 2, 1), 1800, 20);
  ASSERT_TRUE(verdict.warm_at_s);
  // A window is half an hour long, and the noise leaves some of it open.
  EXPECT_NEAR(*verdict.warm_at_s / 3600, 3.0, 0.6);
  EXPECT_LT(std::abs(verdict.now->rate_per_h), 20);
  EXPECT_NEAR(verdict.change, 400, 10);
}

TEST(Rest, IsNotWarmWhileItDrifts) {
  const auto verdict = rest_of(warming(2, 2, 2), 1800, 20);
  EXPECT_FALSE(verdict.warm_at_s);
  ASSERT_TRUE(verdict.now);
  EXPECT_GT(verdict.now->rate_per_h, 50);
}

// Noise that hides a drift of the limit's size: nothing is said to be warm.
TEST(Rest, IsNotCalledWarmOnNoiseThatCouldHideTheDrift) {
  const std::size_t count = 720;
  const stability::Samples noisy{times(count, 10), slow_noise(count, 200, 60, 3)};
  EXPECT_FALSE(rest_of(noisy, 1800, 20).warm_at_s);
}

TEST(Rest, NeedsOneWindow) {
  EXPECT_FALSE(rest_of(warming(0.4, 1, 4), 1800, 1e9).now);
  EXPECT_FALSE(rest_of({}, 1800, 20).now);
}

}  // namespace
}  // namespace driftwise::tests
