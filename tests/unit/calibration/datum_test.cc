// Several datums: one constant each, never tested; the model's own belongs to the first.

#include <gmock/gmock.h>

#include "server/calibration/design/predict.h"
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

}  // namespace
}  // namespace driftwise::calibration
