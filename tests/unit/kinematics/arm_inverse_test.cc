// Inverse solutions held against the forward model.

#include "server/kinematics/arm_inverse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "server/formats/cell_file/kinematics_section.h"

namespace driftwise::kinematics {
namespace {

constexpr double kPi = 3.14159265358979;

// With every error of its joints.
SerialArm bent_ur10() {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/robots/ur10.toml");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  auto arm = *formats::parse_robot_file(text, "ur10.toml");
  arm.frame = {.x_mm = 1500, .y_mm = -900, .z_mm = 40, .rx_deg = 1, .ry_deg = -2, .rz_deg = 60};
  auto& shoulder = arm.links[1].errors;
  shoulder.sag_urad_per_m = 1250;
  shoulder.play_arcsec = 25;
  auto& elbow = arm.links[2].errors;
  elbow.sag_urad_per_m = 740;
  elbow.gear_cos1_arcsec = 30;
  elbow.gear_sin2_arcsec = 12;
  arm.links[3].errors.drift_channel = {"air", "degC"};
  arm.links[3].errors.drift_arcsec_per_k = 4;
  return *SerialArm::create(arm);
}

const std::vector<double> kWarm = {24.0};

SerialArm::Posture posture(const SerialArm& arm, std::vector<double> q) {
  q.push_back(kWarm[0]);
  return arm.posture(q, nominal_values(arm.parameters()));
}

Result<JointSolution> solve(const SerialArm& arm, const SerialArm::Posture& at,
                            const std::vector<double>& near) {
  return nearest_joints(arm, nominal_values(arm.parameters()),
                        {at.tool.translation(), at.tool.linear()}, near, kWarm);
}

TEST(ArmInverse, ReachesThePoseToANanometre) {
  const auto arm = bent_ur10();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(-3, 3), lift(-2.4, -0.6), bend(0.5, 2.2);
  int solved = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<double> q = {angle(random), lift(random),           bend(random),
                                   angle(random), 0.4 + bend(random) / 2, angle(random)};
    const auto at = posture(arm, q);
    const auto solution = solve(arm, at, q);
    if (!solution) continue;  // near a singular pose
    ++solved;
    const auto reached = posture(arm, solution->joints);
    EXPECT_LT((reached.tool.translation() - at.tool.translation()).norm() * 1e6, 1);
    EXPECT_LT((reached.tool.linear() - at.tool.linear()).norm(), 1e-9);
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(solution->joints[j], q[j], 1e-7);
    EXPECT_GE(solution->solutions, 2);
  }
  EXPECT_GE(solved, 8);
}

TEST(ArmInverse, GivesTheSolutionNearestToTheAnglesAskedFor) {
  const auto arm = bent_ur10();
  const std::vector<double> q = {0.3, -1.2, 1.4, -1.0, 1.1, 0.5};
  const auto at = posture(arm, q);
  const auto own = solve(arm, at, q);
  ASSERT_TRUE(own) << own.error().message;
  // The wrist turned over: joint 5 the other way, joints 4 and 6 by half a turn.
  const std::vector<double> over = {0.3, -1.2, 1.4, -1.0 + kPi, -1.1, 0.5 - kPi};
  const auto other = solve(arm, at, over);
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_LT(other->joints[4], 0);
  EXPECT_GT(own->joints[4], 0);
  const auto reached = posture(arm, other->joints);
  EXPECT_LT((reached.tool.translation() - at.tool.translation()).norm() * 1e6, 1);
  // and a turn of 360 degrees is kept
  std::vector<double> wound = q;
  wound[5] += 2 * kPi;
  const auto wound_up = solve(arm, at, wound);
  ASSERT_TRUE(wound_up);
  EXPECT_NEAR(wound_up->joints[5], wound[5], 1e-7);
}

TEST(ArmInverse, EndsTheSearchOnlyWhereNoOtherSolutionIsNearer) {
  const auto arm = bent_ur10();
  const auto values = nominal_values(arm.parameters());
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-3, 3), step(-0.3, 0.3);
  int ended = 0, solved = 0;
  for (int trial = 0; trial < 16; ++trial) {
    std::vector<double> q(6), near(6);
    // Half of them small steps; turned wrists and stretched elbows among them.
    const double size = trial % 2 == 0 ? 0.01 : 1;
    for (std::size_t j = 0; j < 6; ++j) {
      q[j] = angle(random);
      near[j] = q[j] + size * step(random);
    }
    const auto at = posture(arm, q);
    const WantedPose pose{at.tool.translation(), at.tool.linear()};
    const auto all = nearest_joints(arm, values, pose, near, kWarm);
    const auto first = nearest_joints(arm, values, pose, near, kWarm, Search::until_certain);
    ASSERT_EQ(all.has_value(), first.has_value());
    if (!all) continue;
    ++solved;
    ended += first->solutions == 0 ? 1 : 0;
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(first->joints[j], all->joints[j], 1e-9);
  }
  EXPECT_GE(solved, 8);
  EXPECT_GE(ended, 3);
}

TEST(ArmInverse, RefusesPosesNearASingularOneByName) {
  const auto arm = bent_ur10();
  const auto refusal = [&](const std::vector<double>& q) {
    const auto solution = solve(arm, posture(arm, q), q);
    return solution ? std::string("solved") : solution.error().message;
  };
  EXPECT_NE(refusal({0.3, -1.2, 1.4, -1.0, 0.001, 0.5}).find("wrist"), std::string::npos);
  EXPECT_NE(refusal({0.3, -1.2, 0.001, -1.0, 1.1, 0.5}).find("elbow"), std::string::npos);
}

TEST(ArmInverse, RefusesWhatTheArmDoesNotReach) {
  const auto arm = bent_ur10();
  auto at = posture(arm, {0.3, -1.2, 1.4, -1.0, 1.1, 0.5});
  at.tool.translation().x() += 5000;
  const auto solution = solve(arm, at, std::vector<double>(6, 0));
  ASSERT_FALSE(solution);
  EXPECT_NE(solution.error().message.find("reach"), std::string::npos);
}

TEST(ArmInverse, OfThreeJointsIsOfThePoint) {
  KinematicsDescription description;
  description.kind = "serial-arm";
  description.links = {{{"q1", "deg"}, 0, 300, 0, 90, 0},
                       {{"q2", "deg"}, 0, 0, 500, 0, 0},
                       {{"q3", "deg"}, 0, 0, 400, 0, 0}};
  description.links[1].errors.sag_urad_per_m = 900;
  const auto arm = *SerialArm::create(description);
  const auto values = nominal_values(arm.parameters());
  const std::vector<double> q = {20, 40, -70};
  const Eigen::Vector3d point = arm.predict(q, values).value;
  const auto solution = nearest_joints(arm, values, {point, {}}, q, {});
  ASSERT_TRUE(solution) << solution.error().message;
  EXPECT_LT((arm.predict(solution->joints, values).value - point).norm() * 1e6, 1);
  EXPECT_EQ(solution->solutions, 4);  // elbow up and down, each with the base turned round
}

}  // namespace
}  // namespace driftwise::kinematics
