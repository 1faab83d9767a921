// A spread that changes in all outputs at one instant, by too little for any of them alone.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/screen.h"

namespace driftwise::diagnosis {
namespace changes_together_test {
namespace {

constexpr Eigen::Index kRows = 240, kFrom = 150;

Ground ground_of(const Eigen::MatrixXd& series) {
  Timeline timeline{
      Eigen::VectorXd::LinSpaced(kRows, 0, 10.0 * (kRows - 1)), std::vector<char>(kRows, 0), {}};
  timeline.restart.front() = 1;
  const SoftBase base(Eigen::MatrixXd::Ones(kRows, 1), Eigen::VectorXd::Zero(1));
  return {timeline, {{}}, base, series};
}

// mixing: how much of its noise an output has of the first one's.
std::vector<NoiseChange> changes(double ratio, double mixing, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd series = Eigen::MatrixXd::NullaryExpr(kRows, 3, [&] { return normal(random); });
  for (const Eigen::Index o : {1, 2})
    series.col(o) = mixing * series.col(0) + std::sqrt(1 - mixing * mixing) * series.col(o);
  series.bottomRows(kRows - kFrom) *= ratio;
  return noise_changes(ground_of(series));
}

TEST(ASpreadThatChangesInAllOutputs, IsSeenInTheirSum) {
  int seen = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto found = changes(1.75, 0, seed);
    if (found.size() != 3) continue;
    ++seen;
    for (const auto& change : found)
      EXPECT_NEAR(static_cast<double>(change.block), kFrom, 40) << seed;
  }
  EXPECT_GE(seen, 12);
}

// One instrument's noise in all of them is one chance, not three.
TEST(ASpreadThatChangesInAllOutputs, IsNoStrongerForBeingReadThreeTimes) {
  int named = 0;
  for (unsigned seed = 0; seed < 20; ++seed) named += changes(1.45, 0.98, seed).empty() ? 0 : 1;
  EXPECT_LE(named, 2);
}

// Two of three outputs stay as they are; what they seem to change by at that instant is chance.
TEST(ASpreadThatChangesInOneOutput, IsNotSaidOfTheOthers) {
  int of_others = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd series = Eigen::MatrixXd::NullaryExpr(kRows, 3, [&] { return normal(random); });
    series.col(0).tail(kRows - kFrom) *= 4;
    const auto found = noise_changes(ground_of(series));
    ASSERT_FALSE(found.empty()) << seed;
    EXPECT_EQ(found.front().output, 0U) << seed;
    of_others += found.size() > 1 ? 1 : 0;
  }
  EXPECT_LE(of_others, 3) << "of 400 outputs, 1 in 600 each";
}

TEST(ASpreadThatStaysAsItIs, HasNoChange) {
  for (unsigned seed = 0; seed < 200; ++seed) EXPECT_THAT(changes(1, 0, seed), testing::IsEmpty());
}

// Steps of two standard deviations: two readings of three are the same level, and the middle size
// of what is left is that level's distance from the simulation.
TEST(ADisplayOfFewLevels, HasNoSpreadThatChanges) {
  int named = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double level = static_cast<double>(seed % 20) / 20;
    Eigen::MatrixXd series(kRows, 1);
    for (double& value : series.reshaped()) value = 2 * std::round((normal(random) + level) / 2);
    named += noise_changes(ground_of(series)).empty() ? 0 : 1;
  }
  EXPECT_LE(named, 4);  // of 200
}

}  // namespace
}  // namespace changes_together_test
}  // namespace driftwise::diagnosis
