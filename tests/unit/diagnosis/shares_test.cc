#include "server/diagnosis/answer/shares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace driftwise::diagnosis {
namespace {

// A temperature's sine, and a discrepancy of drift_nm_per_k times it with white noise of 5 nm.
struct Rows {
  std::vector<double> t07, x, nm;
};
Rows drifting(double drift_nm_per_k, std::size_t rows = 400) {
  Rows data;
  std::mt19937 random(11);
  std::normal_distribution<double> noise_nm(0, 5);
  for (std::size_t i = 0; i < rows; ++i) {
    data.x.push_back(-4.0 + 0.5 * static_cast<double>(i % 17));
    data.t07.push_back(21 + 0.5 * std::sin(static_cast<double>(i) * 0.05));
    data.nm.push_back(drift_nm_per_k * (data.t07[i] - 21) + noise_nm(random));
  }
  return data;
}

TEST(MarginalShare, IsAllOfItForTheTemperatureThatTheModelLacks) {
  const auto rows = drifting(400);  // 200 nm of a sine: 141 nm rms, 5 nm of noise
  EXPECT_NEAR(marginal_share(rows.t07, rows.nm), 1 - 25.0 / (20'000 + 25), 0.001);
  EXPECT_LT(marginal_share(rows.x, rows.nm), 0.05);
}

TEST(MarginalShare, IsNoneOfNoise) {
  const auto rows = drifting(0);
  EXPECT_LT(marginal_share(rows.t07, rows.nm), 0.05);
}

TEST(MarginalShare, CountsMissingValuesOut) {
  auto rows = drifting(400);
  const double all = marginal_share(rows.t07, rows.nm);
  rows.nm[3] = std::nan("");
  rows.t07[7] = std::nan("");
  EXPECT_NEAR(marginal_share(rows.t07, rows.nm), all, 0.001);
}

TEST(MarginalShare, KeepsItsDigitsFarFromZero) {
  auto rows = drifting(400);
  const double near_zero = marginal_share(rows.t07, rows.nm);
  for (double& kelvin : rows.t07) kelvin += 1e6;
  EXPECT_NEAR(marginal_share(rows.t07, rows.nm), near_zero, 1e-6);
}

TEST(MarginalShare, IsNoneOfThreeRowsOrOfAConstant) {
  const auto few = drifting(400, 3);
  EXPECT_EQ(marginal_share(few.t07, few.nm), 0);
  const auto rows = drifting(400);
  EXPECT_EQ(marginal_share(std::vector<double>(400, 21.0), rows.nm), 0);
}

}  // namespace
}  // namespace driftwise::diagnosis
