// Evidence of the outputs for a step at a row: legs that share one noise are one witness, legs that
// have noise of their own are several.

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/rows/screen.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace outputs_as_witnesses_test {
namespace {

constexpr std::size_t kRows = 400, kAt = 200;
constexpr double kNoise_nm = 10, kStep_nm = 10;

// Both motors step by one standard deviation of the first one's noise; shared, own: how much of
// that noise, and of another, the second motor has.
Dataset two_motors(unsigned seed, double shared, double own) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kRows;
  data.columns = {{{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}, {{"x", "mm"}, {}}, {{"y", "mm"}, {}}};
  for (std::size_t row = 0; row < kRows; ++row) {
    const double x = static_cast<double>(random() % 31) * 0.2 - 3;
    const double y = static_cast<double>(random() % 31) * 0.2 - 3;
    const double common = normal(random), second = normal(random);
    const double step_mm = row < kAt ? 0 : 1e-6 * kStep_nm;
    data.time_s.push_back(25.0 * static_cast<double>(row));
    data.columns[0].values.push_back(x + step_mm + 1e-6 * kNoise_nm * common);
    data.columns[1].values.push_back(y + step_mm +
                                     1e-6 * kNoise_nm * (shared * common + own * second));
    data.columns[2].values.push_back(x);
    data.columns[3].values.push_back(y);
  }
  return data;
}

double evidence(const Dataset& data, const char* formula) {
  const auto problem =
      lay_out(data, *formats::Formula::parse(formula)->expand(data), kMostSearched);
  if (!problem) throw std::runtime_error(problem.error().message);
  return two_ln_likelihood(*problem, {kAt, 0, true}) - two_ln_likelihood(*problem, {kAt, 0, false});
}

// A step of one standard deviation between 200 rows and 200: 2 ln L grows by 400 ln(1 + 1/4) = 89
// in the mean for one witness, less what the step looks like slow noise for. The difference of the
// motors has no slow noise and takes that back, so that together they count up to half as much
// again, but not twice.
TEST(OutputsAsWitnesses, OfOneNoiseAreOne) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Dataset data = two_motors(seed, 1, 0.1);
    const double one = evidence(data, "q1 ~ x + y"), both = evidence(data, "q1 + q2 ~ x + y");
    EXPECT_NEAR(one, 89, 40) << "seed " << seed;
    EXPECT_GT(both, 0.9 * one) << "seed " << seed;
    EXPECT_LT(both, 1.5 * one) << "seed " << seed;
  }
}

TEST(OutputsAsWitnesses, EachOfItsOwnNoiseAreTwo) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Dataset data = two_motors(seed, 0, 1);
    const double first = evidence(data, "q1 ~ x + y"), second = evidence(data, "q2 ~ x + y");
    EXPECT_NEAR(evidence(data, "q1 + q2 ~ x + y"), first + second, 0.1 * (first + second))
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace outputs_as_witnesses_test
}  // namespace driftwise::diagnosis
