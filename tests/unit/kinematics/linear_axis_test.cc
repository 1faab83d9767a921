#include "server/kinematics/linear_axis.h"

#include <gtest/gtest.h>

#include "tests/unit/kinematics/differences.h"

namespace driftwise::kinematics {
namespace {

KinematicsDescription one_axis() {
  KinematicsDescription axis;
  axis.kind = "linear-axis";
  axis.axes.push_back(
      {.motor = {"q1", "mm"}, .pose = {"x", "mm"}, .offset_mm = 0.5, .scale_ppm = 200});
  return axis;
}

TEST(LinearAxis, IsAnOffsetAndAScale) {
  const auto axis = Axis::create(one_axis());
  ASSERT_TRUE(axis);
  const Eigen::VectorXd nominal = nominal_values(axis->parameters());
  EXPECT_DOUBLE_EQ(axis->predict(std::vector<double>{4.5}, nominal).value[0], 4.0 * 1.0002);
  EXPECT_FALSE(axis->predicts_pose());
}

TEST(LinearAxis, JacobianAgreesWithDifferences) {
  const auto axis = Axis::create(one_axis());
  const Eigen::VectorXd values = moved_values(*axis);
  const Eigen::MatrixXd jacobian =
      axis->predict(std::vector<double>{-3.2}, values, Derivatives::yes).jacobian;
  EXPECT_LT((jacobian - jacobian_by_differences(*axis, {-3.2}, values)).norm(), 1e-9);
}

TEST(LinearAxis, IsOneAxis) {
  auto none = one_axis();
  none.axes.clear();
  EXPECT_EQ(make_mechanism(none).error().reason, "BAD_KINEMATICS");
}

}  // namespace
}  // namespace driftwise::kinematics
