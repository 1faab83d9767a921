#include "server/calibration/report/held_out.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/calibration/linear/solution.h"
#include "server/calibration/report/accuracy.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

const std::string kHeldOutFormula = "q1 ~ x + x^2 + t01 + t02";

TEST(HeldOut, EqualsFittingEachBlockAwayByHand) {
  Dataset data = make_campaign({});
  FitOptions options;
  options.select = Select::all;
  options.blocks = 5;
  options.block_gap = 0;
  const auto model = formats::fit_formula(data, kHeldOutFormula, options);
  ASSERT_TRUE(model.has_value());

  // By hand: mark a block's rows as validation, everything else of the calibration rows stays.
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.set[i] == PointSet::calibration) rows.push_back(i);
  double squares = 0;
  options.blocks = 0;
  for (std::size_t block = 0; block < 5; ++block) {
    Dataset part = data;
    const std::size_t begin = rows.size() * block / 5, end = rows.size() * (block + 1) / 5;
    for (std::size_t i = begin; i < end; ++i) part.set[rows[i]] = PointSet::validation;
    const auto fold = formats::fit_formula(part, kHeldOutFormula, options);
    ASSERT_TRUE(fold.has_value());
    const auto& c = fold->outputs[0].coefficients;
    for (std::size_t i = begin; i < end; ++i) {
      const auto value = [&](std::size_t column) { return data.columns[column].values[rows[i]]; };
      const double x = value(1);
      squares += std::pow(
          value(0) - (c[0] + c[1] * x + c[2] * x * x + c[3] * value(2) + c[4] * value(3)), 2);
    }
  }
  const double by_hand = 1.645 * std::sqrt(squares / static_cast<double>(rows.size()));
  EXPECT_NEAR(*model->outputs[0].accuracy.a90_blocks / by_hand, 1, 1e-8);
}

TEST(HeldOut, IntervalHoldsTheFigureAndNarrowsWithData) {
  const auto width = [](int rows) {
    const auto model = formats::fit_formula(make_campaign({.rows = rows}), kHeldOutFormula, {});
    const auto& accuracy = model->outputs[0].accuracy;
    EXPECT_LT(*accuracy.u90_blocks_low, *accuracy.u90_blocks);
    EXPECT_GT(*accuracy.u90_blocks_high, *accuracy.u90_blocks);
    EXPECT_LT(*accuracy.a90_blocks_low, *accuracy.a90_blocks);
    EXPECT_GT(*accuracy.a90_blocks_high, *accuracy.a90_blocks);
    EXPECT_EQ(*accuracy.block_count, 10);
    return *accuracy.a90_blocks_high / *accuracy.a90_blocks_low;
  };
  EXPECT_LT(width(6000), width(300));
}

// Every row after the step is in the last block: the others know no height of it.
TEST(HeldOut, OfAStepThatOneBlockHasIsTheStepAndNoMore) {
  Dataset data = make_campaign({.rows = 900});
  const double instant_s = data.time_s[860], height_mm = 2e-4;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.time_s[i] >= instant_s) data.columns[0].values[i] += height_mm;
  FitOptions options;
  options.select = Select::all;
  const auto model = formats::fit_formula(
      data, "q1 ~ x + x^2 + T + step(" + std::to_string(instant_s) + " s)", options);
  ASSERT_TRUE(model.has_value());
  ASSERT_TRUE(model->outputs[0].accuracy.a90_blocks);
  EXPECT_LT(*model->outputs[0].accuracy.a90_blocks, 1.1 * height_mm);
}

TEST(HeldOut, SeesADriftThatNoTermExplains) {
  Dataset data = make_campaign({.rows = 900});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns[0].values[i] += 5e-5 * std::sin(static_cast<double>(i) / 120);
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  const auto& accuracy = model->outputs[0].accuracy;
  EXPECT_GT(*accuracy.u90_blocks,
            1.15 * *accuracy.u90_validation);  // interleaved rows cannot see it
  EXPECT_GT(accuracy.lag1_autocorrelation, 0.8);
  EXPECT_LT(accuracy.effective_rows, 100);
}

// What the model keeps row by row is what its figures are computed from.
TEST(HeldOut, RowsGiveTheFigures) {
  const Dataset data = make_campaign({});
  const auto model = formats::fit_formula(data, kHeldOutFormula, {});
  ASSERT_TRUE(model.has_value());
  const auto& output = model->outputs[0];
  ASSERT_EQ(output.held_out.size(), data.rows);
  std::vector<double> validation, blocks;
  for (std::size_t row = 0; row < data.rows; ++row)
    (data.set[row] == PointSet::validation ? validation : blocks).push_back(output.held_out[row]);
  const auto on_validation = error_figures(validation), on_blocks = error_figures(blocks);
  EXPECT_EQ(on_blocks.rows, model->lineage.rows_calibration);
  EXPECT_DOUBLE_EQ(on_validation.mean, *output.accuracy.mean_validation);
  EXPECT_DOUBLE_EQ(on_validation.u90, *output.accuracy.u90_validation);
  EXPECT_DOUBLE_EQ(on_validation.a90, *output.accuracy.a90_validation);
  EXPECT_NEAR(on_blocks.mean, *output.accuracy.mean_blocks, 1e-12 * on_blocks.a90);
  EXPECT_NEAR(on_blocks.u90 / *output.accuracy.u90_blocks, 1, 1e-12);
  EXPECT_NEAR(on_blocks.a90 / *output.accuracy.a90_blocks, 1, 1e-12);
}

// A shift of all validation rows is in A90 and in the mean, and not in S90.
TEST(HeldOut, ValidationRowsThatAreShiftedWidenA90) {
  Dataset data = make_campaign({});
  FitOptions options;
  options.lineage.runs = {RunId{1}};
  const auto before = formats::fit_formula(data, kHeldOutFormula, options);
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.set[i] == PointSet::validation) data.columns[0].values[i] += 25e-6;
  const auto after = formats::fit_formula(data, kHeldOutFormula, options);
  ASSERT_TRUE(before.has_value() && after.has_value());
  const auto &a = before->outputs[0].accuracy, &b = after->outputs[0].accuracy;
  EXPECT_NEAR(*b.mean_validation - *a.mean_validation, 25e-6, 1e-12);
  EXPECT_NEAR(*b.u90_validation / *a.u90_validation, 1, 1e-6);
  EXPECT_GT(*b.a90_validation, 1.645 * 24e-6);
  const auto heading = heading_of(*after, *before);
  ASSERT_EQ(heading.size(), 1u);
  EXPECT_EQ(heading[0].output, "q1");
  EXPECT_EQ(heading[0].unit, "nm");
  EXPECT_EQ(heading[0].rows, JudgedRows::validation);
  EXPECT_NEAR(heading[0].figures.a90, *b.a90_validation * 1e6, 1e-9);
  ASSERT_TRUE(heading[0].before.has_value());
  EXPECT_NEAR(heading[0].before->a90, *a.a90_validation * 1e6, 1e-9);
}

// Three loads, each in a stretch of its own: without one of them F and F^2 are one term.
TEST(HeldOut, OfLoadsInStretchesLeavesOutWhatTheOthersDoNotTell) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"force", "N"}, {}}};
  for (int i = 0; i < 300; ++i) {
    const double x = -50 + (i * 37 % 101), force = i < 100 ? 0 : i < 270 ? 2.3 : 5.1;
    data.time_s.push_back(30.0 * i);
    data.columns[0].values.push_back(x + 1e-5 * force + 1e-6 * force * force +
                                     20e-6 * gauss(random));
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(force);
    ++data.rows;
  }
  FitOptions options;
  options.select = Select::all;
  const auto model = formats::fit_formula(data, "q1 ~ x + F + F^2", options);
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(model->outputs[0].accuracy.a90_blocks);
  // The last load alone is told from the others by what they do not know: 5.1 N, 77 nm at most.
  EXPECT_LT(*model->outputs[0].accuracy.a90_blocks, 1.645 * 40e-6);
}

TEST(HeldOut, SaysWhichBlockCouldNotBeFittedAndWhy) {
  Dataset data = make_campaign({.rows = 60});
  data.set.clear();
  data.excluded.assign(data.rows, 0);
  for (std::size_t i = 9; i < data.rows; ++i) data.excluded[i] = 1;
  FitOptions options;
  options.select = Select::all;
  options.blocks = 3;
  options.block_gap = 0;
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + x^3 + t01 + t02", options);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_FALSE(model->outputs[0].accuracy.a90_blocks);
  EXPECT_THAT(model->warnings,
              testing::Contains(testing::HasSubstr(
                  "q1: no figure of held-out blocks of time: without rows 1 to 3 of the fit 6 are "
                  "left for 6 terms")));
}

TEST(HeldOut, IsLeftOutWhereBlocksWouldBeTooSmall) {
  const auto model = formats::fit_formula(make_campaign({.rows = 30}), "q1 ~ x", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_FALSE(model->outputs[0].accuracy.u90_blocks.has_value());
  EXPECT_FALSE(model->outputs[0].accuracy.a90_blocks.has_value());
}

}  // namespace
}  // namespace driftwise::calibration
