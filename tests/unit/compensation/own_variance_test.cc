// The robot's own variance against the definition worked out in another way: r drawn from its
// density on a fine grid, and residuals drawn from a robot whose variance is known.

#include "server/compensation/own_variance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace driftwise::compensation {
namespace {

// Sums over r itself, in steps of a thousandth of the noise.
double by_sums(double scatter2, double noise2, double dof) {
  const double step = 1e-3 * std::sqrt(noise2);
  const auto log_density = [&](double r) {
    const double variance = noise2 + r * r;
    return -0.5 * dof * (std::log(variance / scatter2) + scatter2 / variance);
  };
  const double top = log_density(std::sqrt(std::max(0.0, scatter2 - noise2)));
  double whole = 0, squares = 0;
  for (int k = 0; k < 60'000; ++k) {
    const double r = (k + 0.5) * step, weight = std::exp(log_density(r) - top);
    whole += weight;
    squares += weight * r * r;
  }
  return (dof - 3) / dof * squares / whole;  // s^2 itself without noise
}

TEST(OwnVariance, IsTheExpectationOfANonNegativeOne) {
  for (const double dof : {12.0, 60.0, 340.0, 5000.0})
    for (const double ratio : {0.5, 0.9, 1.0, 1.05, 1.5, 4.0, 50.0}) {
      const double sums = by_sums(400 * ratio, 400, dof);
      EXPECT_NEAR(own_variance(400 * ratio, 400, dof), sums, 1e-5 * sums)
          << "s^2 / noise^2 " << ratio << ", degrees of freedom " << dof;
    }
}

TEST(OwnVariance, IsTheDifferenceWhereTheNoiseExplainsLittle) {
  EXPECT_NEAR(own_variance(10'000, 100, 2000), 9900, 0.01 * 9900);
  EXPECT_NEAR(own_variance(1e8, 1, 1e6), 1e8, 1e-4 * 1e8);
  EXPECT_NEAR(own_variance(400, 1e-6, 10), 400, 1e-3) << "as without noise";
}

TEST(OwnVariance, IsNeverNothingWhereTheScatterIsLessThanTheNoise) {
  const double at = own_variance(400, 400, 340), below = own_variance(360, 400, 340),
               far_below = own_variance(100, 400, 340);
  EXPECT_GT(at, below);
  EXPECT_GT(below, far_below);
  EXPECT_GT(far_below, 0);
  EXPECT_LT(far_below, 0.01 * 400);
}

TEST(OwnVariance, NeedsMoreRowsToBeToldSmall) {
  EXPECT_LT(own_variance(400, 400, 4000), 0.5 * own_variance(400, 400, 400));
}

TEST(OwnVariance, TakesNothingOffWithoutNoiseAndWithFewDegreesOfFreedom) {
  EXPECT_EQ(own_variance(400, 0, 300), 400);
  EXPECT_EQ(own_variance(400, 100, 4), 400);
  EXPECT_EQ(own_variance(0, 100, 300), 0);
  EXPECT_EQ(own_variance(HUGE_VAL, 100, 300), HUGE_VAL) << "of a damaged file";
  EXPECT_EQ(own_variance(std::nan(""), 100, 300), 0);
  EXPECT_NEAR(own_variance(1e300, 2e288, 6), 1e300, 1e290);
  EXPECT_GT(own_variance(1e-300, 1e300, 2e9), 0);
}

// What cutting off at 0 misses: robots of 3 nm behind 20 nm of instruments. Whoever states the root
// of this variance states on average what the robot adds, and seldom far less.
TEST(OwnVariance, StatesWhatARobotAddsInNearlyEveryCampaign) {
  constexpr double kNoise2 = 418, kOwn2 = 9, kDof = 338;
  std::mt19937_64 random(5);
  std::chi_squared_distribution<double> chi2(kDof);
  constexpr int kCampaigns = 400;
  int far_less = 0, cut_far_less = 0;
  double sum = 0;
  for (int k = 0; k < kCampaigns; ++k) {
    const double scatter2 = (kNoise2 + kOwn2) * chi2(random) / kDof;
    const double own2 = own_variance(scatter2, kNoise2, kDof);
    sum += own2 / kCampaigns;
    far_less += own2 < 0.25 * kOwn2 ? 1 : 0;
    cut_far_less += scatter2 - kNoise2 < 0.25 * kOwn2 ? 1 : 0;
  }
  EXPECT_EQ(far_less, 0);
  EXPECT_GT(cut_far_less, kCampaigns / 4);
  EXPECT_GT(sum, kOwn2);
  EXPECT_LT(sum, kOwn2 + kNoise2 * std::sqrt(2 / kDof)) << "no more than the scatter of s^2";
}

// By sums over both standard deviations and the common scale.
double of_two_by_sums(double first2, double second2, double noise2, double dof) {
  const double noise = std::sqrt(noise2), step = 5e-3 * noise;
  constexpr int kCount = 500;
  const auto likelihood = [&](double scatter2) {
    std::vector<double> out;
    for (int k = 0; k < kCount; ++k) {
      const double variance = noise2 + std::pow((k + 0.5) * step, 2);
      out.push_back(
          std::exp(-0.5 * dof * (std::log(variance / scatter2) + scatter2 / variance) + 0.5 * dof));
    }
    return out;
  };
  const auto first = likelihood(first2), second = likelihood(second2);
  double whole = 0, squares = 0;
  for (double t = 0.002 * noise; t < 100 * noise; t *= 1.02) {
    double a = 0, a_squares = 0, b = 0;
    for (int k = 0; k < kCount; ++k) {
      const double r = (k + 0.5) * step, prior = std::exp(-0.5 * r * r / t / t) / t;
      a += prior * first[static_cast<std::size_t>(k)];
      a_squares += r * r * prior * first[static_cast<std::size_t>(k)];
      b += prior * second[static_cast<std::size_t>(k)];
    }
    whole += t * a * b;
    squares += t * a_squares * b;
  }
  return (dof - 3) / dof * squares / whole;
}

TEST(OwnVariances, AreTheExpectationUnderAnUnknownCommonScale) {
  for (const auto& [first, second] :
       {std::pair{400.0, 400.0}, {400.0, 480.0}, {480.0, 400.0}, {350.0, 390.0}, {600.0, 700.0}}) {
    const auto own = own_variances({{first, 400, 200}, {second, 400, 200}});
    const double sums = of_two_by_sums(first, second, 400, 200);
    EXPECT_NEAR(own[0], sums, 0.02 * sums) << first << ", " << second;
  }
}

TEST(OwnVariances, OfOneOutputAreThatOfItAlone) {
  EXPECT_EQ(own_variances({{420, 400, 300}}).front(), own_variance(420, 400, 300));
  const auto with_damaged = own_variances({{420, 400, 300}, {HUGE_VAL, 400, 300}, {10, 0, 300}});
  EXPECT_EQ(with_damaged[0], own_variance(420, 400, 300));
  EXPECT_EQ(with_damaged[1], HUGE_VAL);
  EXPECT_EQ(with_damaged[2], 10);
  EXPECT_TRUE(own_variances({}).empty());
}

TEST(OwnVariances, OfOutputsFarAboveTheNoiseAreAsByThemselves) {
  const auto own = own_variances({{1e6, 400, 800}, {400, 400, 800}, {9e5, 400, 800}});
  EXPECT_NEAR(own[0], 1e6, 1e4);
  EXPECT_NEAR(own[1], own_variance(400, 400, 800), 0.02 * own_variance(400, 400, 800))
      << "an axis unlike the others keeps its own figure";
}

// Three axes that add nothing, 3 nm, or 10 nm each, behind 20 nm of instruments. The common scale
// draws towards 0: of 10 nm a twentieth is lost on average, a seventh of what one campaign can
// tell.
TEST(OwnVariances, StateLessThanEachAloneAndHardlyLessThanTheRobotAdds) {
  constexpr double kNoise2 = 400, kDof = 330;
  std::mt19937_64 random(6);
  std::chi_squared_distribution<double> chi2(kDof);
  for (const double own2 : {0.0, 9.0, 100.0}) {
    double jointly = 0, alone = 0;
    constexpr int kCampaigns = 100;
    for (int k = 0; k < kCampaigns; ++k) {
      std::vector<Scatter> scatter;
      for (int j = 0; j < 3; ++j)
        scatter.push_back({(kNoise2 + own2) * chi2(random) / kDof, kNoise2, kDof});
      for (const double one : own_variances(scatter)) jointly += one / 3 / kCampaigns;
      for (const auto& one : scatter)
        alone += own_variance(one.scatter2, one.noise2, one.dof) / 3 / kCampaigns;
    }
    EXPECT_GT(jointly, 0.85 * own2);
    EXPECT_LT(jointly - own2, 0.7 * (alone - own2) + 0.03 * own2) << "robot of " << own2 << " nm^2";
  }
}

TEST(OwnVariance, CountsRowsThatHangTogetherAsFewer) {
  calibration::OutputModel output;
  output.dof = 300;
  EXPECT_EQ(variance_dof(output), 300);
  output.accuracy.slow_share = 1;
  output.accuracy.slow_rows = 10;
  // A series of first order: (1 - phi^2) / (1 + phi^2) of the rows count.
  const double phi2 = std::exp(-0.2);
  EXPECT_NEAR(variance_dof(output), 300 * (1 - phi2) / (1 + phi2), 1e-9);
}

}  // namespace
}  // namespace driftwise::compensation
