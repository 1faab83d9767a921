#include "server/kinematics/frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <utility>

namespace driftwise::kinematics {
namespace {

Eigen::VectorXd six(double x, double y, double z, double rx, double ry, double rz) {
  Eigen::VectorXd values(6);
  values << x, y, z, rx, ry, rz;
  return values;
}

TEST(Frame, TurnsAboutXFirst) {
  // A quarter turn about x takes y to z; one about z afterwards leaves z alone.
  const Frame frame(six(1, 2, 3, 90, 0, 90));
  EXPECT_LT((frame.outer({0, 1, 0}) - Eigen::Vector3d(1, 2, 4)).norm(), 1e-14);
  EXPECT_LT((frame.outer({1, 0, 0}) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-14);
}

TEST(Frame, InnerUndoesOuter) {
  const Frame frame(six(10, -20, 30, 25, -50, 140));
  const Eigen::Vector3d point(3, 4, 5);
  EXPECT_LT((frame.inner(frame.outer(point)) - point).norm(), 1e-13);
}

TEST(Frame, ValuesOfARotationGiveItBack) {
  const Eigen::VectorXd values = six(10, -20, 30, 25, -50, 140);
  const Frame frame(values);
  EXPECT_LT((frame_values(frame.rotation(), values.head<3>()) - values).norm(), 1e-12);
}

// Only rx - rz shows at a quarter turn up, rx + rz at one down. The detour rounds the zeros.
TEST(Frame, ValuesOfARotationGiveItBackWhereRyIsAQuarterTurn) {
  const Eigen::Matrix3d away =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const auto& [ry_deg, rx_deg] : {std::pair(90.0, 10.0 - 40.0), std::pair(-90.0, 10 + 40.0)}) {
    const Frame frame(six(1, 2, 3, 10, ry_deg, 40));
    const Eigen::Matrix3d rotation = away * (away.transpose() * frame.rotation());
    const Eigen::VectorXd values = frame_values(rotation, {1, 2, 3});
    EXPECT_LT((values - six(1, 2, 3, rx_deg, ry_deg, 0)).norm(), 1e-6) << values.transpose();
    EXPECT_LT((Frame(values).rotation() - frame.rotation()).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(Frame, DerivativesAgreeWithDifferences) {
  const Eigen::VectorXd values = six(10, -20, 30, 25, -50, 140);
  const Eigen::Vector3d point(3, 4, 5);
  for (int k = 0; k < 6; ++k) {
    Eigen::VectorXd up = values, down = values;
    up[k] += 1e-3;
    down[k] -= 1e-3;
    const Eigen::Vector3d outer = (Frame(up).outer(point) - Frame(down).outer(point)) / 2e-3;
    const Eigen::Vector3d inner = (Frame(up).inner(point) - Frame(down).inner(point)) / 2e-3;
    EXPECT_LT((Frame(values).outer_derivatives(point).col(k) - outer).norm(), 1e-9) << k;
    EXPECT_LT((Frame(values).inner_derivatives(point).col(k) - inner).norm(), 1e-9) << k;
  }
}

}  // namespace
}  // namespace driftwise::kinematics
