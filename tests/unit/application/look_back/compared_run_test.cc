#include "server/application/look_back/compared_run.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kPicometre_nm = 1e-3;  // rounding of millimetres as doubles

// Rows of a run at half-hour steps; the second and the last are no returns.
Dataset axis_data() {
  Dataset data;
  data.rows = 6;
  data.time_s = {600, 2400, 4200, 6000, 7800, 9600};
  data.zero = {1, 0, 1, 1, 1, 0};
  data.datum = {1, 1, 1, 1, 2, 2};
  data.columns = {
      {{"q1", "mm"}, {30e-6, 1.0, -20e-6, 10e-6, -15e-6, 2.0}},
      {{"x", "mm"}, {25e-6, 1.0001, -22e-6, 14e-6, -3e-6, 2.0002}},
      {{"t05", "degC"}, {20.0, 20.1, 20.2, 20.3, 20.4, 20.5}},
  };
  return data;
}

std::vector<DatumRecord> datums() {
  DatumRecord first, second;
  first.id = DatumId{1};
  first.values = {{"q1_mm", 5e-6}, {"x_mm", 3e-6}};
  second.id = DatumId{2};
  second.values = {{"q1_mm", -10e-6}};
  return {first, second};
}

auto near(double value) { return DoubleNear(value, kPicometre_nm); }

// By hand, nm: x - (q - q of the datum's zero) is 0, 3, 9, 2.
TEST(ComparedRun, TakesTheAxisOwnPositionOutOfAReturnToZero) {
  ComparedRun run;
  add_measured(axis_data(), datums(), run);
  ASSERT_EQ(run.zero.size(), 1u);
  const auto& x = run.zero[0];
  EXPECT_EQ(x.name, "x");
  EXPECT_THAT(x.values, ElementsAre(near(0), near(3), near(9), near(2)));
  EXPECT_THAT(x.hours, ElementsAre(near(0), near(1), near(1.5), near(2)));
  EXPECT_NEAR(x.range, 9, kPicometre_nm);
  // Least squares: sum (t - 1.125)(v - 3.5) = 4.75 over sum (t - 1.125)^2 = 2.1875.
  ASSERT_TRUE(x.rate_per_h);
  EXPECT_NEAR(*x.rate_per_h, 4.75 / 2.1875, kPicometre_nm);
}

TEST(ComparedRun, TakesLengthsAsTheyAreWhereSeveralAxesMove) {
  auto data = axis_data();
  data.columns.push_back({{"q2", "mm"}, std::vector<double>(6, 0.0)});
  ComparedRun run;
  add_measured(data, datums(), run);
  ASSERT_EQ(run.zero.size(), 1u);
  EXPECT_THAT(run.zero[0].values, ElementsAre(near(0), near(-47), near(-11), near(-28)));
}

TEST(ComparedRun, HasNoRateOfFewerThanThreeValues) {
  auto data = axis_data();
  data.zero = {1, 0, 1, 0, 0, 0};
  ComparedRun run;
  add_measured(data, datums(), run);
  ASSERT_EQ(run.zero.size(), 1u);
  EXPECT_FALSE(run.zero[0].rate_per_h);
  ASSERT_EQ(run.temperatures.size(), 1u);
  EXPECT_NEAR(*run.temperatures[0].rate_per_h, 0.2, kPicometre_nm);
}

}  // namespace
}  // namespace driftwise::application
