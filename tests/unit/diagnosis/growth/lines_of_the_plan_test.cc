// Errors at the beginning of each line of the plan, of another size and sign in every line: their
// mean is nothing, no smooth wave of place or time follows them, and no cause has them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/diagnosis/growth/left_by_a_parabola.h"

namespace driftwise::diagnosis {
namespace lines_of_the_plan_test {
namespace {

using ::testing::HasSubstr;

constexpr int kLines = 24, kRowsPerLine = 9;

// White noise of 5 nm on an axis that is driven back and forth; warm_in: rms over the noise, over
// all rows, of what halves from row to row of each line.
OmnibusResult what_is_left(double warm_in, bool numbered, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Dataset data;
  data.rows = static_cast<std::size_t>(kLines) * kRowsPerLine;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  // Mean square over the rows of the squared halvings 1 + 1/4 + 1/16 + ... over nine rows.
  const double size = warm_in / std::sqrt((4.0 / 3) / kRowsPerLine);
  for (int line = 0; line < kLines; ++line) {
    const double own = size * normal(random);
    for (int i = 0; i < kRowsPerLine; ++i) {
      const double place = line % 2 == 0 ? i : kRowsPerLine - 1 - i;
      data.time_s.push_back(20.0 * static_cast<double>(data.time_s.size()));
      if (numbered) data.line.push_back(line);
      data.columns[1].values.push_back(place);
      data.columns[0].values.push_back(place + 5e-6 * (normal(random) + own * std::pow(0.5, i)));
    }
  }
  return left_by_a_parabola(data);
}

// 0.8 of the noise over 216 rows: chi2 140.
TEST(BeginningOfTheLines, IsSeenAndSaid) {
  const auto left = what_is_left(0.8, true, 1);
  EXPECT_LE(left.p, kOmnibusLevel);
  EXPECT_THAT(left.where, HasSubstr("the beginning of the lines"));
}

TEST(BeginningOfTheLines, IsNothingWhereTheRowsAreNoise) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    alarms += what_is_left(0, true, seed).p <= kOmnibusLevel;
  EXPECT_EQ(alarms, 0);  // 0.1 are to be expected
}

TEST(BeginningOfTheLines, IsNotAskedOfDataWithoutLines) {
  EXPECT_THAT(what_is_left(0.8, false, 1).where, testing::Not(HasSubstr("lines")));
}

}  // namespace
}  // namespace lines_of_the_plan_test
}  // namespace driftwise::diagnosis
