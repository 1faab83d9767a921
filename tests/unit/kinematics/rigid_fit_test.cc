#include "server/kinematics/rigid_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace driftwise::kinematics {
namespace {

TEST(RigidFit, FindsTheRotationAndTranslation) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 100);
  Eigen::Matrix3Xd from(3, 20);
  for (auto& value : from.reshaped()) value = normal(random);
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d translation(1000, -2000, 30);
  const auto fit = fit_rigid(from, (rotation * from).colwise() + translation);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->rotation - rotation).norm(), 1e-12);
  EXPECT_LT((fit->translation - translation).norm(), 1e-9);
  EXPECT_LT(fit->rms, 1e-10);
}

TEST(RigidFit, IsNeverAMirror) {
  // The mirror image would fit exactly; the best rotation leaves something.
  Eigen::Matrix3Xd from(3, 4), to(3, 4);
  from << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  to = from;
  to.row(2) *= -1;
  const auto fit = fit_rigid(from, to);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rotation.determinant(), 1, 1e-12);
  EXPECT_GT(fit->rms, 0.1);
}

TEST(RigidFit, RefusesPointsOnALine) {
  Eigen::Matrix3Xd line(3, 5);
  for (int i = 0; i < 5; ++i) line.col(i) = i * Eigen::Vector3d(1, 2, 3);
  EXPECT_EQ(fit_rigid(line, line).error().reason, "POINTS_ON_A_LINE");
  EXPECT_EQ(fit_rigid(line.leftCols(2), line.leftCols(2)).error().reason, "TOO_FEW_POINTS");
}

}  // namespace
}  // namespace driftwise::kinematics
