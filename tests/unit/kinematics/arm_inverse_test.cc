// Inverse solutions held against the forward model.

#include "server/kinematics/arm_inverse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/kinematics/arm_solver.h"

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
  ASSERT_TRUE(other) << q[0] << ": " << other.error().message;
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

// A wrist whose three axes meet, as most industrial robots have it; forearm and upper arm in line
// at q3 = 0.
SerialArm arm_with_wrist() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{{"q1", "rad"}, 0, 675, 350, -90}, {{"q2", "rad"}, 0, 0, 1350, 0},
               {{"q3", "rad"}, -90, 0, 0, -90},   {{"q4", "rad"}, 0, 1400, 0, 90},
               {{"q5", "rad"}, 0, 0, 0, -90},     {{"q6", "rad"}, 0, 0, 0, 0}};
  return *SerialArm::create(arm);
}

std::string refusal_near(const SerialArm& arm, const std::vector<double>& q) {
  const auto at = arm.posture(q, nominal_values(arm.parameters()));
  const auto solution = nearest_joints(arm, nominal_values(arm.parameters()),
                                       {at.tool.translation(), at.tool.linear()}, q, {});
  return solution ? std::string("solved") : solution.error().reason;
}

// Postures that are singular by construction: joint 5 at 0, joint 3 at 0, the wrist over the axis
// of joint 1.
TEST(ArmInverse, NamesASingularPoseByTheJointsThatMakeIt) {
  const auto arm = arm_with_wrist();
  for (const double angle : {1e-4, 0.004, 0.01})
    EXPECT_EQ(refusal_near(arm, {0.3, -1.2, 0.9, -1.0, angle, 0.5}), "NO_POSE(wrist)") << angle;
  for (const double angle : {1e-4, 0.004, 0.01})
    EXPECT_EQ(refusal_near(arm, {0.3, -1.2, angle, -1.0, 1.1, 0.5}), "NO_POSE(elbow)") << angle;
  // Over the axis of joint 1: 350 + 1350 cos q2 + 1400 cos (q2 + q3) = 0.
  const double q2 = -1.4;
  const double q3 = -std::acos(-(350 + 1350 * std::cos(q2)) / 1400) - q2;
  EXPECT_EQ(refusal_near(arm, {0.3, q2, q3, -1.0, 1.1, 0.5}), "NO_POSE(shoulder)");
  EXPECT_EQ(refusal_near(arm, {0.3, q2, q3 + 0.4, -1.0, 1.1, 0.5}), "solved");
  const auto bent = bent_ur10();
  for (const double angle : {1e-4, 0.01, 0.02}) {
    const std::vector<double> q = {0.3, -1.2, 1.4, -1.0, angle, 0.5};
    const auto solution = solve(bent, posture(bent, q), q);
    ASSERT_FALSE(solution) << angle;
    EXPECT_EQ(solution.error().reason, "NO_POSE(wrist)") << angle;
  }
}

// Number of solutions, from many more starts, drawn otherwise.
template <class Arm>
std::size_t solutions_of(const Arm& arm, const SerialArm::Posture& at,
                         std::span<const double> temperatures) {
  const WantedPose wanted{at.tool.translation(), at.tool.linear()};
  const ArmSolver<6> solver(arm, nominal_values(arm.parameters()), wanted, temperatures);
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> anywhere(-kPi, kPi);
  std::vector<Eigen::Matrix<double, 6, 1>> found;
  for (int start = 0; start < 800; ++start) {
    Eigen::Matrix<double, 6, 1> from;
    for (double& angle : from) angle = anywhere(random);
    const auto solution = solver.solve(from);
    if (!solution) continue;
    const bool known = std::ranges::any_of(found, [&](const auto& other) {
      double apart = 0;
      for (int j = 0; j < 6; ++j)
        apart = std::max(apart, std::abs(std::remainder(other[j] - (*solution)[j], 2 * kPi)));
      return apart < 1e-5;
    });
    if (!known) found.push_back(*solution);
  }
  return found.size();
}

TEST(ArmInverse, FindsAllSolutionsThatManyMoreStartsFind) {
  const auto bent = bent_ur10(), wrist = arm_with_wrist();
  for (const std::vector<double>& q : {std::vector<double>{0.3, -1.2, 1.4, -1.0, 1.1, 0.5},
                                       std::vector<double>{-2.0, -0.8, 1.9, 0.7, 0.8, 1.5},
                                       std::vector<double>{1.2, -2.4, 0.8, 2.0, 1.4, -2.5}}) {
    const auto at = posture(bent, q);
    const auto solution = solve(bent, at, q);
    ASSERT_TRUE(solution) << solution.error().message;
    EXPECT_EQ(static_cast<std::size_t>(solution->solutions), solutions_of(bent, at, kWarm));
    const auto values = nominal_values(wrist.parameters());
    const auto there = wrist.posture(q, values);
    const auto other =
        nearest_joints(wrist, values, {there.tool.translation(), there.tool.linear()}, q, {});
    ASSERT_TRUE(other) << q[0] << ": " << other.error().message;
    EXPECT_EQ(static_cast<std::size_t>(other->solutions), solutions_of(wrist, there, {}));
  }
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

// Links of 500 and 400 mm reach from 100 to 900 mm from the joint between base and upper arm.
TEST(ArmInverse, RefusesWhatTheLinksAreTooShortOrTooLongForBeforeItSearches) {
  KinematicsDescription description;
  description.kind = "serial-arm";
  description.frame.x_mm = 70;
  description.links = {{{"q1", "deg"}, 0, 300, 0, 90, 0},
                       {{"q2", "deg"}, 0, 0, 500, 0, 0},
                       {{"q3", "deg"}, 0, 0, 400, 0, 0}};
  description.links[1].errors.sag_urad_per_m = 900;
  const auto arm = *SerialArm::create(description);
  const auto values = nominal_values(arm.parameters());
  const std::vector<double> far_off = {170, -100, 100};
  const Eigen::Vector3d along = Eigen::Vector3d(2, -1, 2) / 3;
  for (const double mm : {99.0, 101.0, 600.0, 899.0, 901.0}) {
    const WantedPose wanted{Eigen::Vector3d(70, 0, 300) + mm * along, {}};
    const bool reached = mm > 100 && mm < 900;
    EXPECT_EQ(needs_search(arm, values, wanted, far_off, {}), reached) << mm;
    const auto solution = nearest_joints(arm, values, wanted, far_off, {});
    if (reached) {
      EXPECT_TRUE(solution || solution.error().reason == "NO_POSE(elbow)") << mm;
      continue;
    }
    ASSERT_FALSE(solution) << mm;
    EXPECT_EQ(solution.error().reason, "NO_POSE");
    EXPECT_NE(solution.error().message.find(
                  "the point would stand " + std::to_string(static_cast<int>(mm)) +
                  " mm from the middle of joint 1, and the links between them reach from 100 to "
                  "900 mm"),
              std::string::npos)
        << solution.error().message;
  }
}

}  // namespace
}  // namespace driftwise::kinematics
