#include "server/simulation/motor_slopes.h"

#include <gtest/gtest.h>

namespace driftwise::simulation {
namespace {

using effects::Power;
using effects::Term;

calibration::OutputModel slope_output(const std::string& name, const std::string& unit,
                                      std::vector<Term> terms, std::vector<double> coefficients) {
  calibration::OutputModel out;
  out.channel = {name, unit};
  out.terms = std::move(terms);
  out.coefficients = Eigen::Map<Eigen::VectorXd>(coefficients.data(),
                                                 static_cast<Eigen::Index>(coefficients.size()));
  return out;
}

// q1 = 3 + 1.01 x - 0.2 y + 0.01 x^2, q2 = 1000 (0.3 x + 0.9 y) in um: the mean slope of x^2 over
// -1 .. 3 is 2.
TEST(MotorSlopes, AreTheMeanSlopesOverTheDomainInMmPerMm) {
  const Term x{{Power{"x", 1}}}, y{{Power{"y", 1}}}, x2{{Power{"x", 2}}};
  calibration::Model model;
  model.outputs = {slope_output("q1", "mm", {Term{}, x, y, x2}, {3, 1.01, -0.2, 0.01}),
                   slope_output("q2", "um", {x, y}, {300, 900})};
  model.domain = {{{"x", "mm"}, -1, 3}, {{"y", "mm"}, -2, 2}};
  const auto slopes = motor_slopes(model, {"x", "y"});
  ASSERT_TRUE(slopes) << slopes.error().message;
  EXPECT_NEAR((*slopes)(0, 0), 1.01 + 0.02, 1e-12);
  EXPECT_NEAR((*slopes)(0, 1), -0.2, 1e-12);
  EXPECT_NEAR((*slopes)(1, 0), 0.3, 1e-12);
  EXPECT_NEAR((*slopes)(1, 1), 0.9, 1e-12);
  EXPECT_EQ(motor_slopes(model, {"z"}).error().reason, "NO_DOMAIN");
}

}  // namespace
}  // namespace driftwise::simulation
