#include "server/calibration/held_out.h"

#include <gtest/gtest.h>

#include "server/calibration/solution.h"
#include "server/formats/formula.h"
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
  EXPECT_NEAR(*model->outputs[0].accuracy.u90_blocks / by_hand, 1, 1e-8);
}

TEST(HeldOut, IntervalHoldsTheFigureAndNarrowsWithData) {
  const auto width = [](int rows) {
    const auto model = formats::fit_formula(make_campaign({.rows = rows}), kHeldOutFormula, {});
    const auto& accuracy = model->outputs[0].accuracy;
    EXPECT_LT(*accuracy.u90_blocks_low, *accuracy.u90_blocks);
    EXPECT_GT(*accuracy.u90_blocks_high, *accuracy.u90_blocks);
    return *accuracy.u90_blocks_high / *accuracy.u90_blocks_low;
  };
  EXPECT_LT(width(6000), width(300));
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

TEST(HeldOut, IsLeftOutWhereBlocksWouldBeTooSmall) {
  const auto model = formats::fit_formula(make_campaign({.rows = 30}), "q1 ~ x", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_FALSE(model->outputs[0].accuracy.u90_blocks.has_value());
}

}  // namespace
}  // namespace driftwise::calibration
