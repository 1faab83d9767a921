#include "server/identification/method.h"

#include <gtest/gtest.h>

#include "server/calibration/design/predict.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

Dataset crooked_campaign() {
  auto truth = robots::nominal_delta();
  truth.branches[0].length_mm += 0.1;
  truth.branches[1].radius_mm -= 0.07;
  truth.branches[2].tilt_radial_deg = 0.05;
  return robots::delta_campaign(truth, 6, {.mm = 20e-6, .per_degc_mm = 300e-6}, 51);
}

MethodOptions delta_options(const Dataset& data, const std::string& formula,
                            bool with_kinematics = true) {
  MethodOptions options;
  options.fit.candidates = *formats::Formula::parse(formula)->expand(data);
  options.fit.blocks = 0;
  if (with_kinematics) options.mechanism = *kinematics::make_mechanism(robots::nominal_delta());
  return options;
}

const std::string kFormula = "q1 + q2 + q3 ~ poly(x, y, z, 2) + t05";

TEST(Method, HasANameThatReadsBack) {
  for (const Method method :
       {Method::stepwise, Method::nominal, Method::classic, Method::kinematic})
    EXPECT_EQ(method_from(name_of(method)), method);
  EXPECT_FALSE(method_from("neural"));
}

TEST(Method, StepwiseIsTheFitItself) {
  const Dataset data = crooked_campaign();
  const auto options = delta_options(data, kFormula, false);
  const auto fitted = fit_method(data, Method::stepwise, options);
  ASSERT_TRUE(fitted) << fitted.error().message;
  const auto model = calibration::fit(data, options.fit);
  const auto predicted = predict(data, *fitted);
  ASSERT_TRUE(predicted);
  for (std::size_t o = 0; o < 3; ++o)
    EXPECT_EQ(predicted->col(static_cast<Eigen::Index>(o)),
              *calibration::predict(data, model->outputs[o]));
}

// Equations 1.6 to 1.9, by hand: what the nominal inverse model makes of the measured pose, the
// error in motor coordinates, a fit of it, and their sum.
TEST(Method, ClassicIsTheNominalInverseModelPlusAnIdentifiedError) {
  const Dataset data = crooked_campaign();
  const auto options = delta_options(data, kFormula);
  const auto fitted = fit_method(data, Method::classic, options);
  ASSERT_TRUE(fitted) << fitted.error().message;
  const auto predicted = predict(data, *fitted);
  ASSERT_TRUE(predicted);

  auto nominal = robots::nominal_delta();
  Dataset errors = data;
  std::vector<std::vector<double>> igm(3);
  for (std::size_t row = 0; row < data.rows; ++row) {
    const Eigen::Vector3d pose(data.columns[0].values[row], data.columns[1].values[row],
                               data.columns[2].values[row]);
    for (std::size_t k = 0; k < 3; ++k) {
      igm[k].push_back(robots::delta_scale(nominal.branches[k], true, pose));
      errors.columns[3 + k].values[row] -= igm[k].back();
    }
  }
  auto every = options.fit;
  every.select = calibration::Select::all;
  MethodOptions all = options;
  all.fit = every;
  const auto classic = predict(data, *fit_method(data, Method::classic, all));
  const auto error_model = calibration::fit(errors, every);
  ASSERT_TRUE(error_model) << error_model.error().message;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto error = *calibration::predict(errors, error_model->outputs[k]);
    for (std::size_t row = 0; row < data.rows; ++row)
      EXPECT_NEAR((*classic)(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)),
                  igm[k][row] + error[static_cast<Eigen::Index>(row)], 1e-10);
  }
  EXPECT_EQ(predicted->rows(), static_cast<Eigen::Index>(data.rows));
}

TEST(Method, NominalEstimatesOnlyWhereTheRobotReadsZero) {
  const Dataset data = crooked_campaign();
  const auto fitted = fit_method(data, Method::nominal, delta_options(data, kFormula));
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_EQ(fitted->parameters(), 3);
  EXPECT_FALSE(fitted->linear);
}

TEST(Method, WithoutAFormulaTheGeometryAloneIsIdentified) {
  const Dataset data = crooked_campaign();
  MethodOptions options;
  options.mechanism = *kinematics::make_mechanism(robots::nominal_delta());
  const auto fitted = fit_method(data, Method::kinematic, options);
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_TRUE(fitted->kinematics->terms.empty());
  EXPECT_EQ(fit_method(data, Method::classic, options).error().reason, "NO_FORMULA");
}

TEST(Method, NeedsKinematicsUnlessItIsStepwise) {
  const Dataset data = crooked_campaign();
  const auto options = delta_options(data, kFormula, false);
  const auto fitted = fit_method(data, Method::kinematic, options);
  ASSERT_FALSE(fitted);
  EXPECT_EQ(fitted.error().reason, "NO_KINEMATICS");
  EXPECT_NE(fitted.error().message.find("--kinematics"), std::string::npos);
}

TEST(Method, SaysWhatTheRobotPredictsWhenTheFormulaAsksForSomethingElse) {
  const Dataset data = crooked_campaign();
  const auto fitted = fit_method(data, Method::classic, delta_options(data, "q1 + q2 ~ x + y + z"));
  ASSERT_FALSE(fitted);
  EXPECT_EQ(fitted.error().reason, "OTHER_OUTPUTS");
  EXPECT_NE(fitted.error().message.find("predicts q1, q2, q3: write \"q1 + q2 + q3 ~"),
            std::string::npos)
      << fitted.error().message;
}

}  // namespace
}  // namespace driftwise::identification
