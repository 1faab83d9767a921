// Errors of joints against torques written out by hand.

#include "server/kinematics/joint_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/kinematics/serial_arm.h"

namespace driftwise::kinematics {
namespace {

// Shoulder and elbow lift in one plane behind a turn about the vertical.
KinematicsDescription lifting_arm() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{{"q1", "rad"}, 0, 300, 0, 90, 0},
               {{"q2", "rad"}, 0, 0, 500, 0, 0},
               {{"q3", "rad"}, 0, 0, 400, 0, 0}};
  return arm;
}

TEST(GravityTorques, AreWeightTimesHorizontalDistance) {
  auto arm = lifting_arm();
  arm.links[1].mass_kg = 10;
  arm.links[1].mass_centre_mm = {-300, 0, 0};  // 200 mm behind the shoulder
  arm.links[2].mass_kg = 4;
  arm.links[2].mass_centre_mm = {-150, 0, 0};  // 250 mm behind the elbow
  arm.tool_mass_kg = 2;
  const std::vector<double> q = {0.4, 0.3, -0.9};
  const double up = std::cos(0.3), fore = std::cos(0.3 - 0.9), g = 9.80665;
  const double elbow = -g * (4 * 0.25 * fore + 2 * 0.4 * fore);
  const double shoulder =
      -g * (10 * 0.2 * up + 4 * (0.5 * up + 0.25 * fore) + 2 * (0.5 * up + 0.4 * fore));
  const auto torques = gravity_torques(arm, q);
  EXPECT_NEAR(torques[0], 0, 1e-12);  // the vertical axis carries everything
  EXPECT_NEAR(torques[1], shoulder, 1e-12);
  EXPECT_NEAR(torques[2], elbow, 1e-12);
}

TEST(GravityTorques, WithoutMassesAreTheLeverOfLengthsEvenlySpread) {
  const std::vector<double> q = {0, 0.3, -0.9};
  const auto levers = gravity_torques(lifting_arm(), q);
  const double up = std::cos(0.3), fore = std::cos(0.3 - 0.9);
  EXPECT_NEAR(levers[2], -0.2 * fore, 1e-12);
  EXPECT_NEAR(levers[1], -(0.5 * 0.25 * up + 0.4 * (0.5 * up + 0.2 * fore)) / 0.9, 1e-12);
}

TEST(GravityTorques, FollowTheDirectionThatTheFileSays) {
  auto arm = lifting_arm();
  arm.gravity = {0, 0, 1};  // hangs from the ceiling
  const std::vector<double> q = {0, 0.3, -0.9};
  EXPECT_NEAR(gravity_torques(arm, q)[1], -gravity_torques(lifting_arm(), q)[1], 1e-12);
}

TEST(JointErrors, TurnTheJointsOfTheArm) {
  auto arm = lifting_arm();
  arm.links[1].errors.sag_urad_per_m = 800;
  arm.links[1].errors.play_arcsec = 30;
  arm.links[0].errors.gear_cos1_arcsec = 20;
  arm.links[0].errors.gear_sin2_arcsec = -10;
  arm.links[2].errors = {
      .drift_channel = {"t04", "degC"}, .drift_arcsec_per_k = 6, .drift_from_degC = 20};
  const std::vector<double> q = {0.4, 0.3, -0.9}, warm = {22.5};
  constexpr double kArcsec = std::numbers::pi / 648000;
  const double lever = gravity_torques(arm, q)[1];
  const std::vector<double> turned = {q[0] + kArcsec * (20 * std::cos(0.4) - 10 * std::sin(0.8)),
                                      q[1] + 800e-6 * lever - 15 * kArcsec,
                                      q[2] + 6 * 2.5 * kArcsec};
  const auto bent = SerialArm::create(arm);
  const auto straight = SerialArm::create(lifting_arm());
  ASSERT_TRUE(bent && straight);
  ASSERT_EQ(bent->inputs().back().name(), "t04_degC");
  const auto values = nominal_values(bent->parameters());
  std::vector<double> inputs = q;
  inputs.push_back(warm[0]);
  EXPECT_LT((bent->predict(inputs, values).value - straight->predict(turned, values).value).norm(),
            1e-9);
}

TEST(JointErrors, InANumberThatDoesNotFitTheMassesAreRefused) {
  auto arm = lifting_arm();
  arm.links[1].errors.sag_urad_per_newton_m = 5;
  const auto made = SerialArm::create(arm);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("mass_kg"), std::string::npos) << made.error().message;
}

}  // namespace
}  // namespace driftwise::kinematics
