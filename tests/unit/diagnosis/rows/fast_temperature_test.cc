// Temperatures that change from row to row: a chamber that is set anew for each row, a room that is
// read once in eight hours. No neighbour in time foretells them, as if they were a thermometer's
// noise; but the robot follows them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/smoothing.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace fast_temperature_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// 60 rows of a laboratory's sheet: 2 um/K, 0.1 um of noise, between 19 and 23 degC. step_s 0: no
// times.
Dataset sheet(unsigned seed, double step_s) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> set_degC(19, 23);
  Dataset data;
  data.rows = 60;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t07", "degC"}, {}}};
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double x = static_cast<double>(row % 12), t = set_degC(random);
    data.columns[0].values.push_back(x + 2e-3 * (t - 20) + 0.1e-3 * normal(random));
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(t + 0.01 * normal(random));
    if (step_s > 0) data.time_s.push_back(step_s * static_cast<double>(row));
  }
  return data;
}

TEST(ATemperatureThatIsSetAnewForEachRow, IsNamed) {
  for (const double step_s : {0.0, 60.0, 28800.0})
    for (const unsigned seed : {1U, 2U, 3U}) {
      const auto found = diagnosed(sheet(seed, step_s), "q1 ~ x");
      EXPECT_THAT(names_found(found), ElementsAre("thermal_offset t07")) << step_s << ' ' << seed;
    }
}

// 0.1 um times 1.645, by 57 rows to 10 %.
TEST(ATemperatureThatIsSetAnewForEachRow, CountsInTheUsersOwnModel) {
  for (const double step_s : {0.0, 60.0}) {
    const auto found = diagnosed(sheet(4, step_s), "q1 ~ x + t07");
    EXPECT_THAT(names_found(found), IsEmpty()) << step_s;
    EXPECT_EQ(found.verdict, Verdict::adequate) << step_s;
    EXPECT_NEAR(found.outputs[0].a90, 164, 50) << step_s;
  }
}

struct Followed {
  Eigen::MatrixXd base, outputs, shapes;
  Eigen::VectorXd smooth, taken;
};

// 400 rows at 20 degC; the fast part and the thermometer's noise, K; the output in units of noise.
Followed followed(unsigned seed, double slow_k, double fast_k, double noise_k, double per_k) {
  constexpr Eigen::Index kRows = 400;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Followed one{Eigen::MatrixXd::Ones(kRows, 2), Eigen::MatrixXd(kRows, 1),
               Eigen::MatrixXd::Ones(kRows, 1), Eigen::VectorXd(kRows), Eigen::VectorXd(kRows)};
  for (Eigen::Index i = 0; i < kRows; ++i) {
    const double fast = fast_k * normal(random);
    one.base(i, 1) = normal(random);
    one.smooth[i] = 20 + slow_k * std::sin(0.02 * static_cast<double>(i));
    one.taken[i] = fast + noise_k * normal(random);
    one.outputs(i, 0) = per_k * (one.smooth[i] + fast) + 3 * one.base(i, 1) + normal(random);
  }
  return one;
}
double share_of(const Followed& one) {
  return share_followed(one.base, one.outputs, one.smooth, one.taken, one.shapes);
}

TEST(WhatSmoothingTook, IsNotGivenBackWhereItIsTheThermometersNoise) {
  for (unsigned seed = 1; seed <= 300; ++seed)
    EXPECT_EQ(share_of(followed(seed, 0.5, 0, 2e-3, 100)), 0) << seed;
}

// A regressor with as much noise as signal has half of its coefficient (errors in variables).
TEST(WhatSmoothingTook, IsGivenBackAsFarAsItIsNoNoise) {
  double sum = 0;
  for (unsigned seed = 1; seed <= 20; ++seed)
    sum += share_of(followed(seed, 0.5, 5e-3, 5e-3, 300)) / 20;
  EXPECT_NEAR(sum, 0.5, 0.05);
  EXPECT_NEAR(share_of(followed(1, 0.5, 0.5, 1e-3, 300)), 1, 0.02);
  EXPECT_EQ(share_of(followed(1, 0, 0.5, 1e-3, 300)), 1) << "nothing slow to compare it with";
}

// Forty days: no lag of a fortnight can be written in a formula.
TEST(DataOfManyWeeks, AreDiagnosed) {
  const auto found = diagnosed(sheet(5, 86400), "q1 ~ x + t07");
  EXPECT_THAT(names_found(found), IsEmpty());
  Dataset weekly = sheet(6, 7 * 86400.0);
  const auto told = diagnosed(weekly, "q1 ~ x + t07");
  EXPECT_THAT(told.not_testable,
              testing::Contains(testing::AllOf(
                  testing::Field(&NotTestable::cause, "thermal_lag"),
                  testing::Field(&NotTestable::why, testing::HasSubstr("outside its limits")))));
}

}  // namespace
}  // namespace fast_temperature_test
}  // namespace driftwise::diagnosis
