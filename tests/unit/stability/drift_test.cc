#include "server/stability/drift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/stability/noise.h"

namespace driftwise::tests {
namespace {

using stability::drift_of;

TEST(Drift, OfAStraightLineIsExact) {
  const auto time_s = times(100, 60);
  std::vector<double> values;
  for (const double t : time_s) values.push_back(5 + 12 * t / 3600);
  const auto drift = drift_of(time_s, values);
  ASSERT_TRUE(drift);
  EXPECT_NEAR(drift->rate_per_h, 12, 1e-9);
  EXPECT_NEAR(drift->mean, values[49] / 2 + values[50] / 2, 1e-9);
}

TEST(Drift, NeedsEightValues) {
  const std::vector<double> seven(7, 1);
  EXPECT_FALSE(drift_of(times(7, 1), seven));
  EXPECT_FALSE(drift_of(std::vector<double>(8, 1), std::vector<double>(8, 2))) << "one instant";
}

// 200 series without a drift: the stated standard uncertainty is that of the rates found, also
// where the noise is correlated over 10 values. 25 %: sampling of 200 and what the likelihood loses
// on 120 values.
TEST(Drift, StatesItsUncertaintyAlsoForCorrelatedNoise) {
  for (const bool slow : {false, true}) {
    double square = 0, stated = 0;
    constexpr int kSeries = 200;
    const auto time_s = times(120, 60);
    for (int k = 0; k < kSeries; ++k) {
      const auto seed = static_cast<unsigned>(1000 + k);
      const auto values = slow ? slow_noise(120, 3, 10, seed) : white_noise(120, 3, seed);
      const auto drift = drift_of(time_s, values);
      square += drift->rate_per_h * drift->rate_per_h / kSeries;
      stated += drift->u_rate_per_h * drift->u_rate_per_h / kSeries;
    }
    EXPECT_NEAR(std::sqrt(stated / square), 1, 0.25) << (slow ? "correlated" : "white");
  }
}

TEST(BlockMeans, LeaveOutBlocksWithoutValues) {
  const auto means = stability::block_means({{0, 30, 60, 90, 200}, {1, 3, 5, 7, 9}}, 60);
  EXPECT_EQ(means.values, (std::vector<double>{2, 6, 9}));
  EXPECT_EQ(means.time_s, (std::vector<double>{15, 75, 200}));
}

}  // namespace
}  // namespace driftwise::tests
