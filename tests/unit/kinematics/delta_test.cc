#include "server/kinematics/delta.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/kinematics/differences.h"

namespace driftwise::kinematics {
namespace {

KinematicsDescription small_delta(bool above = true) {
  KinematicsDescription delta;
  delta.kind = "delta-vertical";
  delta.carriages_above = above;
  for (int i = 0; i < 3; ++i)
    delta.branches.push_back({.motor = {"q" + std::to_string(i + 1), "mm"},
                              .azimuth_deg = 90.0 + 120 * i,
                              .radius_mm = 30,
                              .length_mm = 50});
  return delta;
}

Delta made(const KinematicsDescription& description) { return *Delta::create(description); }

// What the geometry says, without the room's frames or tilts: the arm from the carriage to the pose
// has its length. 30-40-50 triangles: the carriages stand 40 mm above the pose point.
TEST(Delta, KeepsTheLengthOfItsArms) {
  const auto delta = made(small_delta());
  const Eigen::VectorXd nominal = nominal_values(delta.parameters());
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<double> pose = {uniform(random), uniform(random), uniform(random)};
    const auto q = delta.predict(pose, nominal).value;
    for (int i = 0; i < 3; ++i) {
      const double azimuth = (90.0 + 120 * i) * std::numbers::pi / 180;
      const double dx = pose[0] - 30 * std::cos(azimuth), dy = pose[1] - 30 * std::sin(azimuth);
      EXPECT_NEAR(std::hypot(dx, dy, pose[2] - (40 + q[i])), 50, 1e-12);
    }
  }
}

TEST(Delta, ReadsZeroAtPoseZeroWhateverItsLengths) {
  auto description = small_delta();
  description.branches[1].radius_mm = 28.3;
  description.branches[2].length_mm = 52.1;
  const auto delta = made(description);
  const auto q =
      delta.predict(std::vector<double>{0, 0, 0}, nominal_values(delta.parameters())).value;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(q[i], 0, 1e-13);
}

TEST(Delta, FollowsAVerticalMoveOneToOne) {
  for (const bool above : {true, false}) {
    const auto delta = made(small_delta(above));
    const auto q =
        delta.predict(std::vector<double>{0, 0, 1.25}, nominal_values(delta.parameters())).value;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(q[i], 1.25, 1e-13);
  }
}

TEST(Delta, CarriagesAboveGoUpWhenThePlatformComesTowardsThem) {
  const auto delta = made(small_delta());
  // Branch 1 stands at +y. Coming nearer makes its arm steeper, so its carriage rises.
  const auto q =
      delta.predict(std::vector<double>{0, 1, 0}, nominal_values(delta.parameters())).value;
  EXPECT_NEAR(q[0], std::sqrt(2500 - 29.0 * 29.0) - 40, 1e-12);
  EXPECT_LT(q[1], 0);
}

TEST(Delta, BothDirectionsAreInversesOfEachOther) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (const bool above : {true, false}) {
    const auto delta = made(small_delta(above));
    const Eigen::VectorXd values = moved_values(delta);
    for (int trial = 0; trial < 50; ++trial) {
      const Eigen::Vector3d pose(uniform(random), uniform(random), uniform(random));
      const Eigen::Vector3d q =
          delta.predict(std::span<const double>(pose.data(), 3), values).value;
      const auto back = delta.pose_from_motor(q, values);
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_LT((*back - pose).norm(), 1e-11);
    }
  }
}

TEST(Delta, JacobianAgreesWithDifferences) {
  for (const bool above : {true, false}) {
    const auto delta = made(small_delta(above));
    const Eigen::VectorXd values = moved_values(delta);
    const std::vector<double> pose = {1.3, -0.7, 2.1};
    const Eigen::MatrixXd jacobian = delta.predict(pose, values, Derivatives::yes).jacobian;
    const Eigen::MatrixXd differences = jacobian_by_differences(delta, pose, values);
    for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
      EXPECT_LT((jacobian.col(k) - differences.col(k)).norm(),
                1e-8 * std::max(1e-6, differences.col(k).norm()) + 1e-12)
          << delta.parameters()[static_cast<std::size_t>(k)].name;
  }
}

TEST(Delta, SaysThatAPoseIsOutOfReach) {
  const auto delta = made(small_delta());
  const Eigen::VectorXd nominal = nominal_values(delta.parameters());
  EXPECT_TRUE(std::isnan(delta.predict(std::vector<double>{0, 120, 0}, nominal).value[0]));
  const auto pose = delta.pose_from_motor({300, 0, 0}, nominal);
  ASSERT_FALSE(pose);
  EXPECT_EQ(pose.error().reason, "NO_POSE");
}

TEST(Delta, RefusesWhatIsNoDelta) {
  auto two = small_delta();
  two.branches.pop_back();
  EXPECT_EQ(make_mechanism(two).error().reason, "BAD_KINEMATICS");
  auto stretched = small_delta();
  stretched.branches[0].radius_mm = 50;
  EXPECT_NE(make_mechanism(stretched).error().message.find("radius_mm < length_mm"),
            std::string::npos);
  auto twice = small_delta();
  twice.branches[1].motor = twice.branches[0].motor;
  EXPECT_NE(make_mechanism(twice).error().message.find("q1_mm twice"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::kinematics
