// The mean error of the held-out rows where these are noisier than the rows that learn: an average
// of loud rows errs by more than one of quiet rows.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace held_out_mean_test {
namespace {

// An axis with 1 nm of noise, from the 200th of 300 rows on with 7 nm. Every third row after the
// 150th is held out, and reads too much by this.
Dataset louder_at_the_end(unsigned seed, double held_out_nm) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 300;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const bool held_out = i >= 150 && i % 3 == 0;
    const double x = 2.0 * static_cast<double>(random() % 11);
    const double nm = (i < 200 ? 1 : 7) * normal(random) + (held_out ? held_out_nm : 0);
    data.time_s.push_back(30.0 * static_cast<double>(i));
    data.set.push_back(held_out ? PointSet::validation : PointSet::calibration);
    data.columns[0].values.push_back(x + 1e-6 * nm);
    data.columns[1].values.push_back(x);
  }
  return data;
}

bool mean_is_left_over(const Diagnosis& found) {
  return std::ranges::any_of(found.left_over, [](const LeftOver& one) {
    return one.goes_with.find("held-out rows as a whole") != std::string::npos;
  });
}

TEST(MeanOfHeldOutRows, IsNotBeyondTheNoiseOfTheseRows) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const auto found = diagnosed(louder_at_the_end(seed, 0), "q1 ~ x + x^2");
    EXPECT_FALSE(mean_is_left_over(found)) << seed;
  }
}

// Six standard errors of the mean of 50 such rows.
TEST(MeanOfHeldOutRows, IsSeenBeyondTheNoiseOfTheseRows) {
  for (unsigned seed = 1; seed <= 3; ++seed)
    EXPECT_TRUE(mean_is_left_over(diagnosed(louder_at_the_end(seed, 5.5), "q1 ~ x + x^2"))) << seed;
}

}  // namespace
}  // namespace held_out_mean_test
}  // namespace driftwise::diagnosis
