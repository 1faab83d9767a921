// Verification on points that are written down here.

#include "server/diagnosis/check/verification.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

// Targets 0 .. n - 1 mm; measured 40 nm short of them and 10 nm to and fro.
RunToVerify run_of(std::int64_t id, int points, double short_nm) {
  RunToVerify run;
  run.run = RunId{id};
  run.compensated = true;
  auto& data = run.data;
  data.columns = {{{"x", "mm"}, {}}, {{"x_target", "mm"}, {}}, {{"t01", "degC"}, {}}};
  for (int i = 0; i < points; ++i) {
    data.zero.push_back(i == 0 ? 1 : 0);
    data.columns[0].values.push_back(i - (short_nm + (i % 2 == 0 ? 10 : -10)) * 1e-6);
    data.columns[1].values.push_back(i);
    data.columns[2].values.push_back(20 + 0.1 * i);
    ++data.rows;
  }
  return run;
}

TEST(Verification, IsTargetMinusMeasuredWithoutTheReturnsToZero) {
  const auto found = verify_runs(std::vector{run_of(3, 9, 40)}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  const auto& run = found->runs.front();
  EXPECT_EQ(run.rows, 8);
  EXPECT_EQ(run.rows_zero, 1);
  ASSERT_EQ(run.coordinates.size(), 1u);
  const auto& x = run.coordinates.front();
  EXPECT_NEAR(x.all.mean, 40, 1e-6);
  EXPECT_NEAR(x.all.u90, 1.645 * std::sqrt(8 * 100.0 / 7), 1e-6);
  EXPECT_NEAR(x.all.a90, 1.645 * std::sqrt(1600 + 100.0), 1e-6);
  EXPECT_NEAR(x.largest, 50, 1e-6);
  EXPECT_EQ(x.largest_row, 2u);
  EXPECT_FALSE(x.by_model.has_value());
  EXPECT_EQ(found->heading.front().figures, x.all);
  EXPECT_FALSE(found->heading.front().before.has_value());
}

TEST(Verification, TellsInsideFromOutsideTheModelsRange) {
  calibration::Model model;
  model.domain = {{{"x", "mm"}, 0, 5}, {{"t01", "degC"}, 20, 20.75}};
  const auto found = verify_runs(std::vector{run_of(3, 9, 40)}, &model);
  ASSERT_TRUE(found) << found.error().message;
  const auto& run = found->runs.front();
  EXPECT_EQ(run.rows_outside, 3);  // x = 6, 7, 8; t01 at 8 alone
  EXPECT_EQ(run.coordinates.front().inside.rows, 5);
  EXPECT_EQ(run.coordinates.front().outside.rows, 3);
  EXPECT_EQ(run.outside, (std::vector<std::string>{"x_mm above 5", "t01_degC above 20.75"}));
}

TEST(Verification, ComparesOnThePositionsThatBothVisited) {
  const auto found =
      verify_runs(std::vector{run_of(3, 9, 40), run_of(4, 7, 400), run_of(5, 9, -20)}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->changes.size(), 2u);
  EXPECT_EQ(found->changes[0].positions, 6);
  const auto& x = found->changes[0].coordinates.front();
  EXPECT_NEAR(x.before->mean, 400, 1e-6);
  EXPECT_NEAR(x.figures.mean, 40, 1e-6);
  EXPECT_EQ(x.figures.rows, 6);
  EXPECT_EQ(found->heading.front().before->a90, x.before->a90);
}

// Run of an axis with q = 2 x that misses its own targets: 30 nm too far in q is 15 nm in x.
RunToVerify run_that_missed() {
  RunToVerify run = run_of(3, 9, 0);
  auto& data = run.data;
  data.columns.push_back({{"q1", "mm"}, {}});
  data.columns.push_back({{"q1_cmd", "mm"}, {}});
  for (int i = 0; i < 9; ++i) {
    const double target = i, missed_mm = (i % 3 - 1) * 30e-6;
    data.columns[0].values[static_cast<std::size_t>(i)] = target + missed_mm / 2;
    data.columns[3].values.push_back(2 * target + missed_mm);
    data.columns[4].values.push_back(2 * target);
  }
  return run;
}

// Misses of the axis's own target are no error of the model.
TEST(Verification, TakesTheAxesOwnMissesOut) {
  RunToVerify run = run_that_missed();
  calibration::Model model;
  calibration::OutputModel q1;
  q1.channel = {"q1", "mm"};
  q1.terms = {effects::Term{}, *formats::parse_term("x")};
  q1.coefficients = Eigen::Vector2d(0, 2);
  model.outputs = {q1};
  run.model = std::make_shared<const calibration::Model>(model);
  const auto found = verify_runs(std::vector{run}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  const auto& x = found->runs.front().coordinates.front();
  EXPECT_GT(x.all.a90, 15);
  ASSERT_TRUE(x.by_model.has_value());
  EXPECT_LT(x.by_model->a90, 0.01);
}

// q = 2 x with q in um and x in m, the range in K: figures are those of the run's own units.
TEST(Verification, ReadsAModelInOtherUnitsInThoseOfTheRun) {
  RunToVerify run = run_that_missed();
  calibration::Model model;
  calibration::OutputModel q1;
  q1.channel = {"q1", "um"};
  q1.terms = {effects::Term{}, *formats::parse_term("x")};
  q1.coefficients = Eigen::Vector2d(0, 2e6);
  model.outputs = {q1};
  model.domain = {{{"x", "m"}, 0, 5e-3}, {{"t01", "K"}, 293.15, 293.9}};
  run.model = std::make_shared<const calibration::Model>(model);
  const auto found = verify_runs(std::vector{run}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  const auto& x = found->runs.front().coordinates.front();
  ASSERT_TRUE(x.by_model.has_value());
  EXPECT_LT(x.by_model->a90, 0.01);
  EXPECT_EQ(verify_runs(std::vector{run}, &model)->runs.front().rows_outside, 3);

  model.domain[1].channel.unit = "N";
  const auto refused = verify_runs(std::vector{run}, &model);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "UNITS_DISAGREE");
}

// The same readings with the column of a symbol given in another unit: value * factor / divisor.
RunToVerify in_unit(RunToVerify run, const std::string& symbol, const std::string& unit,
                    double factor, double divisor) {
  for (auto& column : run.data.columns)
    if (column.channel.symbol == symbol) {
      column.channel.unit = unit;
      for (double& value : column.values) value = value * factor / divisor;
    }
  return run;
}

TEST(Verification, IsTheSameWhateverUnitsTargetAndMeasurementHave) {
  const RunToVerify in_mm = run_of(3, 9, 40);
  const RunToVerify um = in_unit(in_mm, "x", "um", 1e3, 1);
  for (const auto& run :
       {um, in_unit(um, "x_target", "m", 1, 1e3), in_unit(in_mm, "x_target", "nm", 1e6, 1)}) {
    const auto found = verify_runs(std::vector{run}, nullptr);
    ASSERT_TRUE(found) << found.error().message;
    const auto& x = found->runs.front().coordinates.front();
    EXPECT_NEAR(x.all.mean, 40, 1e-5);
    EXPECT_NEAR(x.all.a90, 1.645 * std::sqrt(1600 + 100.0), 1e-5);
    EXPECT_NEAR(x.largest, 50, 1e-5);
  }
  // What was commanded of the one axis, in um, is the target of an x in mm.
  RunToVerify commanded = in_unit(in_mm, "x_target", "um", 1e3, 1);
  commanded.data.columns[1].channel.symbol = "q1_cmd";
  const auto found = verify_runs(std::vector{commanded}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->runs.front().coordinates.front().all.mean, 40, 1e-5);
}

// Targets such as 0.3 mm, which no other unit has to the last bit.
TEST(Verification, FindsThePositionsOfRunsInOtherUnitsAndInAnotherOrderOfTheColumns) {
  RunToVerify run = run_of(3, 9, 40), against = run_of(4, 9, 400);
  for (auto* one : {&run, &against})
    for (auto& column : one->data.columns)
      if (column.channel.symbol.starts_with("x"))
        for (double& value : column.values) value *= 0.3;
  against = in_unit(in_unit(against, "x", "um", 1e3, 1), "x_target", "m", 1, 1e3);
  for (auto* one : {&run, &against}) {
    auto y = one->data.columns[0], wanted = one->data.columns[1];
    y.channel.symbol = "y";
    wanted.channel.symbol = "y_target";
    for (double& value : y.values) value *= 2;
    for (double& value : wanted.values) value *= 2;
    one->data.columns.push_back(std::move(y));
    one->data.columns.push_back(std::move(wanted));
  }
  std::ranges::reverse(against.data.columns);
  const auto found = verify_runs(std::vector{run, against}, nullptr);
  ASSERT_TRUE(found) << found.error().message;
  const auto& change = found->changes.front();
  EXPECT_EQ(change.positions, 8);
  ASSERT_EQ(change.coordinates.size(), 2u);
  ASSERT_TRUE(change.coordinates[0].before.has_value());
  EXPECT_NEAR(change.coordinates[0].figures.mean, 40 * 0.3, 1e-5);
  EXPECT_NEAR(change.coordinates[0].before->mean, 400 * 0.3, 1e-5);
  EXPECT_NEAR(change.coordinates[1].before->mean, 400 * 0.6, 1e-5);
}

TEST(Verification, RefusesATargetOfAnotherKindThanTheMeasurement) {
  const auto refused =
      verify_runs(std::vector{in_unit(run_of(3, 9, 40), "x_target", "deg", 1, 1)}, nullptr);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "UNITS_DISAGREE");
  EXPECT_EQ(refused.error().message.find("run 3 gives x_target in deg and x in mm"), 0u)
      << refused.error().message;
}

TEST(Verification, SaysWhatARunLacks) {
  RunToVerify none;
  none.run = RunId{7};
  none.data = run_of(7, 5, 0).data;
  none.data.columns.erase(none.data.columns.begin() + 1);
  EXPECT_EQ(verify_runs(std::vector{none}, nullptr).error().reason, "NO_TARGETS");
  EXPECT_EQ(verify_runs(std::vector{run_of(3, 2, 0)}, nullptr).error().reason, "TOO_FEW_ROWS");
  // One axis that was told positions: what was commanded is what was wanted.
  none.data.columns.push_back({{"q1_cmd", "mm"}, {0, 1, 2, 3, 4}});
  EXPECT_TRUE(verify_runs(std::vector{none}, nullptr));
}

}  // namespace
}  // namespace driftwise::diagnosis
