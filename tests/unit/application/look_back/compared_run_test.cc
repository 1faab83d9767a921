#include "server/application/look_back/compared_run.h"

#include <gmock/gmock.h>

#include <string>
#include <utility>

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

// The same run with its axis and its length in another unit.
class ComparedUnit : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(ComparedUnit, GivesReturnsInNanometres) {
  const auto [unit, per_mm] = GetParam();
  auto data = axis_data();
  for (auto& column : data.columns) {
    if (column.channel.unit != "mm") continue;
    column.channel.unit = unit;
    for (double& value : column.values) value *= per_mm;
  }
  auto zeros = datums();
  for (auto& datum : zeros)
    for (auto& value : datum.values)
      value = {value.channel.substr(0, value.channel.find('_') + 1) + unit, value.value * per_mm};
  ComparedRun run;
  add_measured(data, zeros, run);
  ASSERT_EQ(run.zero.size(), 1u);
  EXPECT_EQ(run.zero[0].unit, "nm");
  EXPECT_THAT(run.zero[0].values, ElementsAre(near(0), near(3), near(9), near(2)));
}

INSTANTIATE_TEST_SUITE_P(Each, ComparedUnit,
                         testing::Values(std::pair{"m", 1e-3}, std::pair{"mm", 1.0},
                                         std::pair{"um", 1e3}, std::pair{"nm", 1e6}),
                         [](const auto& unit) { return std::string(unit.param.first); });

TEST(ComparedRun, GivesRotationsInSecondsOfArcAndTemperaturesInKelvin) {
  auto data = axis_data();
  data.columns = {{{"rx", "deg"}, {0, 0, 1, 2, 3, 0}},
                  {{"ry", "rad"}, {0, 0, 1e-6, 2e-6, 3e-6, 0}},
                  {{"t07", "K"}, {293, 293, 294, 294, 295, 295}},
                  {{"t07_std", "K"}, {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}}};
  ComparedRun run;
  add_measured(data, {}, run);
  ASSERT_EQ(run.zero.size(), 2u);
  EXPECT_EQ(run.zero[0].unit, "arcsec");
  EXPECT_NEAR(run.zero[0].range, 3 * 3600, 1e-6);
  EXPECT_EQ(run.zero[1].unit, "arcsec");
  EXPECT_NEAR(run.zero[1].range, 3 * 0.206265, 1e-5);
  ASSERT_EQ(run.temperatures.size(), 1u) << "a spread is no temperature";
  EXPECT_EQ(run.temperatures[0].name, "t07");
  EXPECT_EQ(run.temperatures[0].unit, "K");
  EXPECT_DOUBLE_EQ(run.temperatures[0].range, 2);
}

TEST(ComparedRun, NamesTheUnitThatResidualsAreIn) {
  ModelResiduals residuals;
  residuals.data = axis_data();
  residuals.outputs = {{{"q1", "um"}, std::vector<double>(6, 4.0), {}},
                       {{"q2", "rad"}, std::vector<double>(6, 4.0), {}}};
  ComparedRun run;
  add_residuals(residuals, run);
  ASSERT_EQ(run.residuals.size(), 2u);
  EXPECT_EQ(run.residuals[0].unit, "nm");
  EXPECT_EQ(run.residuals[1].unit, "arcsec");
}

// One row is wrong by 1 mm and kept out, and one is a passage.
TEST(ComparedRun, HasNoRowInItsFiguresThatIsKeptOut) {
  ModelResiduals residuals;
  residuals.data = axis_data();
  residuals.data.excluded = {0, 0, 1, 0, 4, 0};
  residuals.data.columns.push_back({{"t07", "degC"}, {20, 21, 80, 22, -300, 23}});
  residuals.outputs = {{{"q1", "mm"}, {4, -7, 1e6, 5, -2e6, 0}, {}}};
  ComparedRun run;
  add_residuals(residuals, run);
  add_measured(residuals.data, datums(), run);
  ASSERT_EQ(run.residuals.size(), 1u);
  EXPECT_THAT(run.residuals[0].values, ElementsAre(4, -7, 5, 0));
  EXPECT_DOUBLE_EQ(run.residuals[0].range, 12);
  ASSERT_FALSE(run.temperatures.empty());
  EXPECT_DOUBLE_EQ(run.temperatures.back().range, 3);
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
