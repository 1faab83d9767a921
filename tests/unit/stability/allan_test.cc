#include "server/stability/allan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "server/stability/stretch.h"
#include "tests/unit/stability/noise.h"

namespace driftwise::tests {
namespace {

using stability::allan_deviation;
using testing::HasSubstr;

// The 1000-point test suite of NIST Special Publication 1065, section 12.4: n' = 16807 n mod
// 2147483647 from 1234567890 on, each divided by the modulus.
std::vector<double> nist_1000_points() {
  constexpr std::int64_t kModulus = 2147483647;
  std::vector<double> values;
  for (std::int64_t n = 1234567890; values.size() < 1000; n = 16807 * n % kModulus)
    values.push_back(static_cast<double>(n) / static_cast<double>(kModulus));
  return values;
}

// Table 31 of the same publication, "Overlapping Allan", at averaging factors 1, 10 and 100. It
// prints seven digits.
TEST(AllanDeviation, GivesThePublishedValuesOfTheNistDataSet) {
  const auto values = nist_1000_points();
  const std::size_t factors[] = {1, 10, 100};
  const auto points = allan_deviation(values, 1, factors);
  ASSERT_EQ(points.size(), 3U);
  EXPECT_NEAR(points[0].deviation, 2.922319e-01, 5e-8);
  EXPECT_NEAR(points[1].deviation, 9.159953e-02, 5e-9);
  EXPECT_NEAR(points[2].deviation, 3.241343e-02, 5e-9);
  EXPECT_EQ(points[1].tau_s, 10);
}

// sigma(m) = sd / sqrt(m). 100 000 values: below 4 % of sampling up to m = 64.
TEST(AllanDeviation, OfWhiteNoiseFallsWithTheRootOfTheAveraging) {
  const auto values = white_noise(100'000, 2.5, 7);
  const std::size_t factors[] = {1, 4, 16, 64};
  for (const auto& point : allan_deviation(values, 0.5, factors))
    EXPECT_NEAR(point.deviation, 2.5 / std::sqrt(static_cast<double>(point.factor)),
                0.04 * point.deviation)
        << point.factor;
}

// sigma^2(m) = q (2 m^2 + 1) / (6 m) for steps of variance q.
TEST(AllanDeviation, OfARandomWalkFollowsItsClosedForm) {
  const auto values = random_walk(200'000, 0.3, 11);
  const std::size_t factors[] = {1, 4, 16, 64};
  for (const auto& point : allan_deviation(values, 1, factors)) {
    const double m = static_cast<double>(point.factor);
    const double expected = std::sqrt(0.09 * (2 * m * m + 1) / (6 * m));
    EXPECT_NEAR(point.deviation, expected, 0.06 * expected) << m;
  }
}

// A straight line of slope d per value: every difference of means m apart is m d.
TEST(AllanDeviation, OfADriftIsExact) {
  std::vector<double> line(400);
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = 1e6 + 0.25 * static_cast<double>(i);
  const std::size_t factors[] = {1, 10, 100};
  for (const auto& point : allan_deviation(line, 1, factors))
    EXPECT_NEAR(point.deviation, 0.25 * static_cast<double>(point.factor) / std::sqrt(2), 1e-9);
}

TEST(AllanDeviation, LeavesOutWhatTheValuesCannotTell) {
  const std::vector<double> four{1, 2, 1, 2};
  const std::size_t factors[] = {0, 1, 2, 3};
  EXPECT_EQ(allan_deviation(four, 1, factors).size(), 2U);
  EXPECT_TRUE(allan_deviation({}, 1, factors).empty());
}

TEST(NoiseSentence, NamesTheKindAndTheBestAveragingTime) {
  auto values = white_noise(65'536, 1, 3);
  const auto walk = random_walk(values.size(), 0.02, 5);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += walk[i];
  const auto sentence =
      stability::noise_sentence(allan_deviation(values, 2, stability::octaves(values.size())));
  EXPECT_THAT(sentence, HasSubstr("white noise at the shortest times"));
  EXPECT_THAT(sentence, HasSubstr("a random walk at the longest"));
  EXPECT_THAT(sentence, HasSubstr("does not help"));
}

TEST(LongestStretch, EndsAtAGap) {
  stability::Samples series{{0, 10, 20, 100, 110, 120, 130, 141, 400}, std::vector<double>(9, 1)};
  const auto stretch = stability::longest_stretch(series);
  EXPECT_EQ(stretch.begin, 3U);
  EXPECT_EQ(stretch.end, 8U);
  EXPECT_EQ(stretch.interval_s, 10);
  EXPECT_EQ(stability::longest_stretch({{1}, {1}}).size(), 0U);
}

TEST(Allan, CallsAConstantChannelNoNoise) {
  const std::vector<double> still(4096, 21.3);
  using namespace stability;
  EXPECT_TRUE(noise_sentence(allan_deviation(still, 1, octaves(still.size())))
                  .starts_with("no noise: every value is the same"));
}

}  // namespace
}  // namespace driftwise::tests
