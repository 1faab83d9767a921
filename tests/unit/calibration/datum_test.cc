// Several datums: one constant each, never tested; the model's own belongs to the first.

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/calibration/design/predict.h"
#include "server/calibration/report/accuracy.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

double coefficient(const OutputModel& output, const std::string& name) {
  for (std::size_t i = 0; i < output.terms.size(); ++i)
    if (effects::notation(output.terms[i]) == name)
      return output.coefficients[static_cast<Eigen::Index>(i)];
  ADD_FAILURE() << name << " is not in";
  return 0;
}

TEST(Datum, GetsAConstantOfItsOwnThatIsNeverTested) {
  const auto model = formats::fit_formula(make_campaign({.datums = 3}), "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto& output = model->outputs[0];
  // Made with 0.5 um of the scale per datum: as if the zeros lay that far along the axis.
  ASSERT_EQ(model->datum_zeros.size(), 2u);
  EXPECT_NEAR(coefficient(output, "datum(3)"), 0, 1e-9);
  EXPECT_NEAR(model->datum_zeros[1].pose[0].value, 1e-3, 2e-6);
  EXPECT_NEAR(output.accuracy.rmse, 3e-6, 0.5e-6);
}

TEST(Datum, KeepsItsConstantWhereItIsNotMoved) {
  FitOptions options;
  options.move_datums = false;
  const auto model =
      formats::fit_formula(make_campaign({.datums = 3}), "q1 ~ x + x^2 + T", options);
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto& output = model->outputs[0];
  EXPECT_TRUE(model->datum_zeros.empty());
  EXPECT_NEAR(coefficient(output, "datum(2)"), 5e-4, 2e-6);
  EXPECT_NEAR(coefficient(output, "datum(3)"), 1e-3, 2e-6);
  for (const auto& step : output.history)
    EXPECT_FALSE(effects::datum_of(step.term)) << "was tested";
  EXPECT_NEAR(output.accuracy.rmse, 3e-6, 0.5e-6);
}

TEST(Datum, StaysInEvenWhenItMeansNothing) {
  Dataset data = make_campaign({});
  data.datum.assign(data.rows, 7);
  for (std::size_t i = data.rows / 2; i < data.rows; ++i) data.datum[i] = 9;
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_NEAR(coefficient(model->outputs[0], "datum(2)"), 0, 3e-6);
}

TEST(Datum, WithoutCalibrationRowsTakesNoPartInTheValidation) {
  Dataset data = make_campaign({.datums = 2});
  for (std::size_t i = data.rows / 2; i < data.rows; ++i) data.set[i] = PointSet::validation;
  const auto model = formats::fit_formula(data, "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_NEAR(*model->outputs[0].accuracy.u90_validation, 1.645 * 3e-6, 1.5e-6);
  EXPECT_THAT(model->warnings,
              testing::Contains(testing::HasSubstr("200 validation rows left out")));
}

TEST(Datum, IsNotAddedToAModelThroughZero) {
  FitOptions options;
  options.select = Select::all;
  const auto model = formats::fit_formula(make_campaign({.datums = 2}), "q1 ~ x - 1", options);
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_EQ(model->outputs[0].terms.size(), 1u);
}

TEST(Datum, HeldOutBlocksAreJudgedWithoutItsUnknownConstant) {
  FitOptions options;
  options.blocks = 4;  // one block is exactly one datum
  const auto model =
      formats::fit_formula(make_campaign({.rows = 600, .datums = 4}), "q1 ~ x + x^2 + T", options);
  ASSERT_TRUE(model.has_value());
  EXPECT_LT(*model->outputs[0].accuracy.u90_blocks, 2 * 1.645 * 3e-6);
}

// q = x + 2e-4 (t - 20) + a constant of each datum + white noise of 20 nm. rows: of each datum.
Dataset homed_anew(const std::vector<int>& rows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> place(-50, 50);
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t04", "degC"}, {}}};
  for (std::size_t d = 0; d < rows.size(); ++d) {
    const double homed = 4e-3 * gauss(random);
    for (int i = 0; i < rows[d]; ++i) {
      const double x = place(random), t = 20 + gauss(random);
      data.time_s.push_back(30.0 * static_cast<double>(data.rows++));
      data.datum.push_back(static_cast<std::int64_t>(d));
      data.columns[0].values.push_back(x + 2e-4 * (t - 20) + homed + 20e-6 * gauss(random));
      data.columns[1].values.push_back(x);
      data.columns[2].values.push_back(t);
    }
  }
  return data;
}

std::vector<int> datums_of_rows(int first, int further, int rows_each) {
  std::vector<int> rows(static_cast<std::size_t>(further), rows_each);
  rows.insert(rows.begin(), first);
  return rows;
}

// The truth is 1.645 * 20 nm for every row that says something of its error. A datum of two rows
// that no training has leaves one degree of freedom to both, one of a single row none.
TEST(Datum, RowsOfADatumHeldOutCountWithTheDegreesOfFreedomTheyHave) {
  FitOptions options;
  options.select = Select::all;
  for (const auto& rows : {datums_of_rows(30, 30, 1), datums_of_rows(30, 30, 2)}) {
    double squares = 0;
    constexpr int kSeeds = 6;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const Dataset data = homed_anew(rows, seed);
      const auto model = formats::fit_formula(data, "q1 ~ x + t04", options);
      ASSERT_TRUE(model) << model.error().message;
      squares += std::pow(*model->outputs[0].accuracy.a90_blocks, 2) / kSeeds;
      int unjudged = 0;
      for (const double error : model->outputs[0].held_out) unjudged += std::isnan(error) ? 1 : 0;
      // Of datums of two rows those alone that the border of a block leaves one row of.
      if (rows.back() == 1)
        EXPECT_EQ(unjudged, 30);
      else
        EXPECT_LE(unjudged, 8);
    }
    EXPECT_NEAR(std::sqrt(squares) / (1.645 * 20e-6), 1, 0.12) << rows.back();
  }
}

// Without the only block of the first datum the constant and datum(k) are one column too many.
TEST(Datum, OfOneBlockLeavesTheHeldOutFigureOfTheOthers) {
  FitOptions options;
  options.select = Select::all;
  const auto model =
      formats::fit_formula(homed_anew({20, 140, 140}, 3), "q1 ~ x + x^2 + t04", options);
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(model->outputs[0].accuracy.a90_blocks);
  EXPECT_NEAR(*model->outputs[0].accuracy.a90_blocks / (1.645 * 20e-6), 1, 0.15);
  EXPECT_EQ(heading_of(*model)[0].rows, JudgedRows::blocks);
}

TEST(Datum, WithoutACompleteRowHasNoConstantAndIsNoBase) {
  FitOptions options;
  options.select = Select::all;
  for (const std::size_t lost : {0u, 1u}) {
    Dataset data = homed_anew({30, 135, 135}, 5);
    for (std::size_t row = 0; row < data.rows; ++row)
      if (data.datum[row] == static_cast<std::int64_t>(lost))
        data.columns[2].values[row] = kMissing;
    std::vector<std::string> kept;
    const auto model = formats::fit_formula(data, "q1 ~ x + t04", options);
    ASSERT_TRUE(model) << model.error().message;
    for (const auto& term : model->outputs[0].terms)
      if (effects::datum_of(term)) kept.push_back(effects::notation(term));
    EXPECT_EQ(kept, std::vector<std::string>{"datum(3)"}) << "lost: datum " << lost + 1;
    EXPECT_NEAR(model->outputs[0].accuracy.rmse, 20e-6, 3e-6);
  }
}

}  // namespace
}  // namespace driftwise::calibration
