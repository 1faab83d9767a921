#include "server/application/motion/zero_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace driftwise::application {
namespace {

TEST(PredictZeroShift, WithoutReturnsIsZeroWithinTheDeclaredLimit) {
  const std::vector<double> warming{0.5, 0.0};
  const auto p = predict_zero_shift({}, warming);
  EXPECT_EQ(p.shift_nm, 0);
  EXPECT_NEAR(p.sd_nm, std::hypot(0.5 * kPriorNmPerKelvin, kDatumNoise_nm), 1e-9);
}

TEST(PredictZeroShift, LearnsFromTheRunsOwnReturns) {
  std::vector<ZeroObservation> seen;
  for (int i = 0; i < 60; ++i) {
    const double a = 0.01 * i, b = 0.3 * std::sin(0.4 * i);
    seen.push_back({{a, b}, 200 * a - 50 * b});
  }
  const std::vector<double> warming{0.7, -0.2};
  const auto p = predict_zero_shift(seen, warming);
  EXPECT_NEAR(p.shift_nm, 200 * 0.7 + 50 * 0.2, 5);
  EXPECT_LT(p.sd_nm, 10);  // and says so
  EXPECT_EQ(p.observations, 60u);
}

TEST(PredictZeroShift, DoesNotBelieveTwoSensorsThatMovedTogether) {
  // Only the sum was ever seen: a warming of one alone is uncertain by the prior.
  std::vector<ZeroObservation> seen;
  for (int i = 0; i < 60; ++i) seen.push_back({{0.01 * i, 0.01 * i}, 2.0 * i});
  const std::vector<double> together{0.6, 0.6}, one{0.6, 0.0};
  EXPECT_LT(predict_zero_shift(seen, together).sd_nm, 15);
  EXPECT_GT(predict_zero_shift(seen, one).sd_nm, 60);
}

TEST(ZeroComparison, IsSurprisedByMoreThanThreeDeviations) {
  ZeroComparison c{{100, 10, 50}, 130};
  EXPECT_FALSE(c.surprising());
  EXPECT_NEAR(c.difference_nm(), 30, 1e-12);
  c.found_nm = 1000;
  EXPECT_TRUE(c.surprising());
  EXPECT_NE(c.sentence().find("+1000 nm"), std::string::npos);
}

TEST(Drift, IsTheSlopePerMinute) {
  const std::vector<double> t{0, 10, 20, 30}, zero{5, 6, 7, 8};
  EXPECT_DOUBLE_EQ(drift_nm_per_min(t, zero), 6);
}

}  // namespace
}  // namespace driftwise::application
