#include "server/simulation/forward_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/core/data/reading.h"

namespace driftwise::simulation {
namespace {

using effects::Power;
using effects::Term;

Term power(const std::string& symbol, int exponent = 1) { return Term{{Power{symbol, exponent}}}; }

calibration::OutputModel output(const std::string& name, std::vector<Term> terms,
                                std::vector<double> coefficients) {
  calibration::OutputModel out;
  out.channel = {name, "mm"};
  out.terms = std::move(terms);
  out.coefficients = Eigen::Map<Eigen::VectorXd>(coefficients.data(),
                                                 static_cast<Eigen::Index>(coefficients.size()));
  return out;
}

// q1 = 0.01 + 1.002 x + 3e-4 x^2 - 2e-4 t07
calibration::Model linear_axis() {
  calibration::Model model;
  model.outputs = {
      output("q1", {Term{}, power("x"), power("x", 2), power("t07")}, {0.01, 1.002, 3e-4, -2e-4})};
  model.domain = {{{"x", "mm"}, -4, 4}, {{"t07", "degC"}, 20, 22}};
  return model;
}

TEST(ForwardModel, GivesBackThePoseThatTheModelWasAskedFor) {
  auto forward = ForwardModel::create(linear_axis(), {"x", "t07"});
  ASSERT_TRUE(forward);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any_x_mm(-4, 4), any_degc(20, 22);
  for (int i = 0; i < 200; ++i) {
    const double x_mm = any_x_mm(random), t07 = any_degc(random);
    const double q_mm = 0.01 + 1.002 * x_mm + 3e-4 * x_mm * x_mm - 2e-4 * t07;
    const auto pose = forward->step(i, std::vector{q_mm}, std::vector{kMissing, t07});
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_NEAR((*pose)[0], x_mm, 1e-12);
  }
}

TEST(ForwardModel, SolvesCoupledAxes) {
  calibration::Model model;
  const Term xy{{Power{"x", 1}, Power{"y", 1}}};
  model.outputs = {output("q1", {power("x"), power("y"), xy}, {1.0, 0.3, 0.01}),
                   output("q2", {power("x"), power("y"), power("x", 2)}, {-0.2, 1.1, 0.02})};
  model.domain = {{{"x", "mm"}, -1, 1}, {{"y", "mm"}, -1, 1}};
  auto forward = ForwardModel::create(model, {"x", "y"});
  ASSERT_TRUE(forward);
  const double x = 0.4, y = -0.7;
  const auto pose =
      forward->step(0, std::vector{x + 0.3 * y + 0.01 * x * y, -0.2 * x + 1.1 * y + 0.02 * x * x},
                    std::vector{0.0, 0.0});
  ASSERT_TRUE(pose);
  EXPECT_NEAR((*pose)[0], x, 1e-12);
  EXPECT_NEAR((*pose)[1], y, 1e-12);
}

TEST(ForwardModel, NeedsAsManyOutputsAsPoseAxes) {
  auto model = linear_axis();
  model.domain.push_back({{"y", "mm"}, 0, 1});
  const auto forward = ForwardModel::create(model, {"x", "y", "t07"});
  ASSERT_FALSE(forward);
  EXPECT_EQ(forward.error().reason, "NOT_SQUARE");
}

TEST(ForwardModel, RefusesAMissingTemperature) {
  auto forward = ForwardModel::create(linear_axis(), {"x", "t07"});
  const auto pose = forward->step(0, std::vector{1.0}, std::vector{1.0, kMissing});
  ASSERT_FALSE(pose);
  EXPECT_EQ(pose.error().reason, "MISSING_VALUE");
}

TEST(ForwardModel, SaysSoWhenNoPoseFits) {
  calibration::Model model;
  model.outputs = {output("q1", {Term{}, power("x", 2)}, {1.0, 1.0})};  // q >= 1
  model.domain = {{{"x", "mm"}, -4, 4}};
  auto forward = ForwardModel::create(model, {"x"});
  const auto pose = forward->step(0, std::vector{-1.0}, std::vector{0.5});
  ASSERT_FALSE(pose);
  EXPECT_EQ(pose.error().reason, "NO_CONVERGENCE");
}

}  // namespace
}  // namespace driftwise::simulation
