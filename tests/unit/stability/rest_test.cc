#include "server/stability/rest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

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

// Values every interval_s for this many minutes, from the value of the series' end on.
void go_on(stability::Samples& series, double minutes, double interval_s, double rate_per_h) {
  const double begin_s = series.time_s.empty() ? 0 : series.time_s.back();
  const double begin = series.values.empty() ? 20 : series.values.back();
  for (double t = interval_s; t <= 60 * minutes; t += interval_s) {
    series.time_s.push_back(begin_s + t);
    series.values.push_back(begin + rate_per_h * t / 3600);
  }
}

void leave_out(stability::Samples& series, double minutes) {
  series.time_s.push_back(series.time_s.back() + 60 * minutes);
  series.values.push_back(series.values.back());
}

// Two quarters of an hour with ten hours of nothing in between are no half hour, and the second
// one rises at ten times the limit.
TEST(Rest, IsNotCalledWarmOnAWindowWithAHoleOfHours) {
  stability::Samples series;
  go_on(series, 15, 10, 0);
  leave_out(series, 600);
  go_on(series, 15, 10, 0.5);
  const auto verdict = rest_of(series, 1800, 0.05);
  EXPECT_FALSE(verdict.warm_at_s);
  EXPECT_FALSE(verdict.now);
  EXPECT_NEAR(verdict.change, 0.125, 0.01);
}

TEST(Rest, BeginsAnewBehindAHole) {
  for (const auto& [hole_min, begins_s] : {std::pair(5.0, 0.0), std::pair(10.0, 4200.0)}) {
    stability::Samples series;
    go_on(series, 60, 10, 0);
    leave_out(series, hole_min);
    go_on(series, 60, 10, 0);
    const auto verdict = rest_of(series, 1800, 0.05);
    ASSERT_TRUE(verdict.warm_at_s) << hole_min;
    EXPECT_NEAR(*verdict.warm_at_s, begins_s, 60) << hole_min;  // one block
  }
}

// Every two minutes: 15 of the 30 blocks have a value. The last half hour rises at four times the
// limit; the half hour before it, which a window of 30 values would hold too, does not.
TEST(Rest, JudgesASlowChannelOverTheSameTime) {
  stability::Samples series;
  go_on(series, 40, 120, 0);
  auto verdict = rest_of(series, 1800, 0.05);
  ASSERT_TRUE(verdict.now);
  ASSERT_TRUE(verdict.warm_at_s);
  EXPECT_NEAR(*verdict.warm_at_s, 120, 1e-9);
  go_on(series, 30, 120, 0.2);
  verdict = rest_of(series, 1800, 0.05);
  EXPECT_FALSE(verdict.warm_at_s);
  ASSERT_TRUE(verdict.now);
  EXPECT_NEAR(verdict.now->rate_per_h, 0.2, 1e-6);
}

TEST(Rest, DoesNotJudgeAChannelWithFewerThanEightValuesPerWindow) {
  stability::Samples series;
  go_on(series, 600, 300, 0);
  EXPECT_FALSE(rest_of(series, 1800, 0.05).now);
  EXPECT_FALSE(rest_of(series, 1800, 0.05).warm_at_s);
}

TEST(Rest, NeedsOneWindow) {
  EXPECT_FALSE(rest_of(warming(0.4, 1, 4), 1800, 1e9).now);
  EXPECT_FALSE(rest_of({}, 1800, 20).now);
}

}  // namespace
}  // namespace driftwise::tests
