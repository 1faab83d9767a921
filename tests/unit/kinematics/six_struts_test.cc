// Against what does not come from the code: distances between joints, a hand-worked case, finite
// differences.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "server/kinematics/sigma6_plan.h"

namespace driftwise::kinematics {
namespace {

constexpr double kLength_mm = 60, kReach_mm = 30, kSpacing_mm = 40;
constexpr double kNm = 1e-6;
const double kDegree = std::acos(-1.0) / 180;

SixStruts robot() {
  return *SixStruts::create(orthogonal_struts(kLength_mm, kReach_mm, kSpacing_mm));
}

SixPose random_pose(std::mt19937_64& random, double stroke_mm, double turn_rad) {
  std::uniform_real_distribution<double> move(-stroke_mm, stroke_mm), turn(-turn_rad, turn_rad);
  SixPose pose;
  for (Eigen::Index k = 0; k < 3; ++k) pose.position_mm[k] = move(random);
  for (Eigen::Index k = 0; k < 3; ++k) pose.rotation_rad[k] = turn(random);
  return pose;
}

TEST(SixStruts, StandAtMotorZeroAtPoseZero) {
  const auto motors = *robot().motors({});
  for (const double q : motors) EXPECT_NEAR(q, 0, 1e-12);
}

TEST(SixStruts, MoveAlongXByThePairAlongXAndTheRestByItsArms) {
  const double x_mm = 2;
  const auto q = *robot().motors({{x_mm, 0, 0}, Eigen::Vector3d::Zero()});
  EXPECT_NEAR(q[0], x_mm, 1e-12);
  EXPECT_NEAR(q[1], x_mm, 1e-12);
  // Struts across the motion swing: their carriages follow by L - sqrt(L^2 - x^2).
  const double swing_mm = kLength_mm - std::sqrt(kLength_mm * kLength_mm - x_mm * x_mm);
  for (std::size_t i = 2; i < kStruts; ++i) EXPECT_NEAR(q[i], swing_mm, 1e-12) << i;
}

TEST(SixStruts, KeepTheirLengthsAtEveryPose) {
  const auto struts = orthogonal_struts(kLength_mm, kReach_mm, kSpacing_mm);
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const auto pose = random_pose(random, 2, 3 * kDegree);
    const auto q = *robot().motors(pose);
    const double angle = pose.rotation_rad.norm();
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(angle, pose.rotation_rad / angle).toRotationMatrix();
    for (std::size_t k = 0; k < kStruts; ++k) {
      const Eigen::Vector3d joint = pose.position_mm + rotation * struts[k].platform_mm;
      const Eigen::Vector3d carriage = struts[k].base_mm + q[k] * struts[k].direction;
      EXPECT_NEAR((joint - carriage).norm(), kLength_mm, 1e-12);
    }
  }
}

TEST(SixStruts, GoForwardAndBackWithinANanometreOverTheSigma6Workspace) {
  std::mt19937_64 random(6);
  double worst_nm = 0, worst_arcsec = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto pose = random_pose(random, 2, 3 * kDegree);
    const auto found = robot().pose(*robot().motors(pose));
    ASSERT_TRUE(found) << found.error().message;
    worst_nm = std::max(worst_nm, (found->position_mm - pose.position_mm).norm() / kNm);
    worst_arcsec =
        std::max(worst_arcsec, (found->rotation_rad - pose.rotation_rad).norm() / kDegree * 3600);
  }
  EXPECT_LT(worst_nm, 1e-3);  // asked for: 1 nm
  EXPECT_LT(worst_arcsec, 1e-5);
}

TEST(SixStruts, HaveTheSlopesOfFiniteDifferences) {
  std::mt19937_64 random(7);
  const auto pose = random_pose(random, 2, 2 * kDegree);
  const auto slopes = *robot().jacobian(pose);
  const double step = 1e-5;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto moved = [&](double sign) {
      SixPose at = pose;
      if (k < 3) {
        at.position_mm[k] += sign * step;
      } else {
        const auto turn = [](const Eigen::Vector3d& vector) {
          return Eigen::AngleAxisd(vector.norm(), vector.normalized()).toRotationMatrix();
        };
        const Eigen::AngleAxisd both(Eigen::Matrix3d(
            turn(sign * step * Eigen::Vector3d::Unit(k - 3)) * turn(pose.rotation_rad)));
        at.rotation_rad = both.angle() * both.axis();
      }
      return *robot().motors(at);
    };
    const auto up = moved(1), down = moved(-1);
    for (std::size_t i = 0; i < kStruts; ++i)
      EXPECT_NEAR(slopes(static_cast<Eigen::Index>(i), k), (up[i] - down[i]) / (2 * step), 2e-8)
          << i << ' ' << k;
  }
}

TEST(SixStruts, ThatAreTooShortSayWhichOne) {
  const auto q = robot().motors({{0, 70, 0}, Eigen::Vector3d::Zero()});
  ASSERT_FALSE(q);
  EXPECT_EQ(q.error().reason, "NO_POSE");
  EXPECT_NE(q.error().message.find("strut 1"), std::string::npos);
}

TEST(SixStruts, ThatLeaveAMotionFreeAreRefused) {
  auto struts = orthogonal_struts(kLength_mm, kReach_mm, 0);  // nothing holds the rotations
  EXPECT_EQ(SixStruts::create(struts).error().reason, "RANK_DEFICIENT");
}

TEST(Sigma6Plan, HasThePublishedPointsAndHours) {
  const auto stages = *sigma6_stages(robot());
  ASSERT_EQ(stages.size(), 6u);
  EXPECT_EQ(stages[0].plan.points.size(), 11319u);
  for (std::size_t k = 1; k <= 3; ++k) EXPECT_EQ(stages[k].plan.points.size(), 3564u);
  EXPECT_EQ(stages[4].plan.points.size(), 729u);
  EXPECT_EQ(stages[5].set_ups, 33);
  double published_h = 0, preparation_h = 0;
  for (const auto& stage : stages) {
    published_h += stage.published_h;
    preparation_h += stage.set_ups * (stage.prepare_h + stage.stabilise_h);
  }
  EXPECT_DOUBLE_EQ(published_h, 629.5);
  EXPECT_DOUBLE_EQ(preparation_h, 40 * 9.5);  // 4 + 3 + 33 set-ups
}

TEST(MirrorPrism, CarriesTheAutocollimatorToItsFacets) {
  const auto prism = sigma6_prism();
  const auto read = facet_for(prism, 1.5 * 3600 - 250);
  ASSERT_TRUE(read);
  EXPECT_EQ(prism.facets_arcsec[read->facet], 5400);
  EXPECT_DOUBLE_EQ(read->reading_arcsec, -250);
  EXPECT_EQ(facet_for(prism, 100)->facet, 2u);
}

TEST(MirrorPrism, DoesNotReadBetweenItsFacets) {
  const auto read = facet_for(sigma6_prism(), 2700);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("the nearest that is read is"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::kinematics
