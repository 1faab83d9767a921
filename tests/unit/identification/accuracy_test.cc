#include "server/identification/accuracy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/core/data/row_marks.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

Dataset campaign() {
  auto truth = robots::nominal_delta();
  truth.branches[0].length_mm += 0.1;
  truth.branches[1].radius_mm -= 0.07;
  return robots::delta_campaign(truth, 6, {.mm = 20e-6, .per_degc_mm = 300e-6}, 61);
}

MethodOptions judged_options(const Dataset& data) {
  MethodOptions options;
  options.fit.candidates =
      *formats::Formula::parse("q1 + q2 + q3 ~ poly(x, y, z, 3) + t05")->expand(data);
  options.mechanism = *kinematics::make_mechanism(robots::nominal_delta());
  return options;
}

Judgement judged(const Dataset& data, Method method, const JudgeOptions& judge = {}) {
  auto result = judge_method(data, method, judged_options(data), judge);
  EXPECT_TRUE(result) << result.error().message;
  return std::move(*result);
}

TEST(JudgeMethod, SaysHowManyRowsHaveNoValueInAChannelThatIsRead) {
  Dataset data = campaign();
  auto& t05 = std::ranges::find_if(data.columns, [](const auto& column) {
                return column.channel.symbol == "t05";
              })->values;
  for (std::size_t row = 0; row < data.rows; row += 2) t05[row] = kMissing;
  data.excluded.assign(data.rows, 0);
  data.excluded[0] = 1;  // kept out before: not counted again
  for (const Method method : {Method::kinematic, Method::stepwise}) {
    const auto result = judged(data, method);
    const auto half = std::to_string((data.rows + 1) / 2 - 1);
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_EQ(result.warnings.front(),
              half + " of " + std::to_string(data.rows) +
                  " rows left out: a channel that is read has no value there");
  }
}

// Without a target where the run came by, as a return to zero of its own has none.
TEST(JudgeMethod, CountsNoPassageAmongTheFirstRows) {
  Dataset data = campaign();
  auto options = judged_options(data);
  options.fit.first_rows = 100;
  const auto plain = judge_method(data, Method::stepwise, options, {});
  ASSERT_TRUE(plain) << plain.error().message;
  const auto repeated = [](auto& values) {
    if (!values.empty()) values.insert(values.begin() + 50, 10, values[50]);
  };
  repeated(data.time_s), repeated(data.set), repeated(data.line), repeated(data.zero);
  repeated(data.dwell_s), repeated(data.run), repeated(data.datum);
  for (auto& column : data.columns) repeated(column.values);
  data.rows += 10;
  data.excluded.assign(data.rows, kInUse);
  for (std::size_t row = 50; row < 60; ++row) {
    data.excluded[row] = kPassageRow;
    for (auto& column : data.columns) column.values[row] = kMissing;
  }
  const auto passed = judge_method(data, Method::stepwise, options, {});
  ASSERT_TRUE(passed) << passed.error().message;
  EXPECT_EQ(passed->rows_calibration, 100);
  EXPECT_EQ(passed->rows_calibration, plain->rows_calibration);
  EXPECT_EQ(passed->outputs[0].rms, plain->outputs[0].rms);
}

TEST(JudgeMethod, GivesStepwiseTheFiguresThatTheFitItselfGives) {
  Dataset data = campaign();
  data.set.assign(data.rows, PointSet::calibration);
  for (std::size_t row = 0; row < data.rows; row += 5) data.set[row] = PointSet::validation;
  data.datum.assign(data.rows, 1);
  for (std::size_t row = 150; row < data.rows; ++row) data.datum[row] = 2;
  auto options = judged_options(data);
  // Each fold here would find the datum's zero again, which the fit itself does once, from all
  // rows.
  options.fit.move_datums = false;
  const auto judgement = judge_method(data, Method::stepwise, options, {});
  ASSERT_TRUE(judgement) << judgement.error().message;
  const auto& result = *judgement;
  const auto model = calibration::fit(data, options.fit);
  ASSERT_TRUE(model);
  for (std::size_t o = 0; o < 3; ++o) {
    const auto& expected = model->outputs[o].accuracy;
    const auto& figures = result.outputs[o];
    EXPECT_NEAR(figures.u90_calibration, expected.u90_calibration, 1e-9 * expected.u90_calibration);
    EXPECT_NEAR(*figures.u90_validation, *expected.u90_validation, 1e-9 * *expected.u90_validation);
    // Two roads to the same folds: the whole fit again, and segments of one triangle.
    EXPECT_NEAR(figures.blocks->figures.a90, *expected.a90_blocks, 1e-5 * *expected.a90_blocks);
    EXPECT_NEAR(figures.blocks->figures.u90, *expected.u90_blocks, 1e-5 * *expected.u90_blocks);
    EXPECT_NEAR(figures.blocks->low, *expected.a90_blocks_low, 1e-5 * *expected.a90_blocks_low);
    EXPECT_EQ(figures.parameters, static_cast<int>(model->outputs[o].terms.size()));
  }
  EXPECT_EQ(result.rows_validation, 44);
}

TEST(JudgeMethod, TheRightGeometryPredictsAsWellAsItsNoise) {
  const auto kinematic = judged(campaign(), Method::kinematic);
  const auto nominal = judged(campaign(), Method::nominal);
  for (std::size_t o = 0; o < 3; ++o) {
    EXPECT_LT(kinematic.outputs[o].blocks->figures.a90, 1.3 * 1.645 * 20e-6);
    EXPECT_GT(nominal.outputs[o].blocks->figures.a90, 300e-6);
  }
}

TEST(JudgeMethod, KeepsGroupsTogetherAndFindsTheirPureError) {
  Dataset data = campaign();
  const Dataset once = data;
  // Every pose three times over, each with its own noise.
  for (int visit = 1; visit < 3; ++visit) {
    const Dataset more = robots::delta_campaign(
        [] {
          auto truth = robots::nominal_delta();
          truth.branches[0].length_mm += 0.1;
          truth.branches[1].radius_mm -= 0.07;
          return truth;
        }(),
        6, {.mm = 20e-6, .per_degc_mm = 300e-6}, 70 + static_cast<unsigned>(visit));
    for (std::size_t c = 0; c < data.columns.size(); ++c)
      data.columns[c].values.insert(data.columns[c].values.end(), more.columns[c].values.begin(),
                                    more.columns[c].values.end());
    for (const double time : more.time_s) data.time_s.push_back(time + 1e4 * visit);
  }
  data.rows = 3 * once.rows;
  for (std::size_t row = 0; row < data.rows; ++row)
    data.line.push_back(static_cast<std::int64_t>(row % once.rows));
  const auto result = judged(data, Method::kinematic, {.together = "line"});
  EXPECT_EQ(result.groups, 216);
  for (const auto& output : result.outputs) {
    ASSERT_TRUE(output.groups);
    ASSERT_TRUE(output.pure_error);
    // 432 degrees of freedom, three outputs: 20 nm within 12 % at 3.5 standard deviations.
    EXPECT_NEAR(*output.pure_error, 20e-6, 2.4e-6);
    EXPECT_LT(output.groups->figures.a90, 1.3 * 1.645 * 20e-6);
  }
  ASSERT_TRUE(result.position);
  EXPECT_NEAR(*result.position->pure_error, std::sqrt(3.0) * 20e-6, 2e-6);
}

TEST(JudgeMethod, LooksAtTheSameRowsWhateverTheMethodReads) {
  Dataset data = campaign();
  data.columns[6].values[10] = kMissing;  // t05: stepwise reads it, the nominal robot does not
  EXPECT_EQ(judged(data, Method::stepwise).rows_calibration, 215);
  EXPECT_EQ(judged(data, Method::nominal).rows_calibration, 215);
}

TEST(JudgeMethod, SaysWhyThereIsNoHeldOutFigure) {
  const Dataset whole = campaign();
  Dataset data = whole;
  data.rows = 10;  // enough for 7 terms, but not with a third of them held out
  data.time_s.clear();
  for (std::size_t c = 0; c < data.columns.size(); ++c) {
    data.columns[c].values.clear();
    for (std::size_t i = 0; i < data.rows; ++i)
      data.columns[c].values.push_back(whole.columns[c].values[23 * i]);
  }
  auto options = judged_options(data);
  options.fit.candidates =
      *formats::Formula::parse("q1 + q2 + q3 ~ poly(x, y, 2) + t05")->expand(data);
  options.fit.select = calibration::Select::all;
  const auto result = judge_method(data, Method::stepwise, options, {.blocks = 3});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_FALSE(result->outputs.front().blocks);
  ASSERT_EQ(result->warnings.size(), 1U);
  EXPECT_TRUE(result->warnings[0].starts_with(
      "stepwise: no held-out figure by blocks of time: 6 complete calibration rows"))
      << result->warnings[0];
}

}  // namespace
}  // namespace driftwise::identification
