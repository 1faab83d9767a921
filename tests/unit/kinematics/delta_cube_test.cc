// Delta Cube 2 as a robot file: a delta whose axes stand at right angles, against its closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/kinematics/delta.h"

namespace driftwise::kinematics {
namespace {

constexpr double kArm_mm = 60;

Delta delta_cube() {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/data/robots/delta_cube_2.toml");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto description = formats::parse_robot_file(text, "delta_cube_2.toml");
  if (!description) throw std::runtime_error(description.error().message);
  return *Delta::create(*description);
}

// Pythagoras: the arm in line with its axis gives way to the two other coordinates.
double motor_of(double own_mm, double other_mm, double third_mm) {
  return own_mm - kArm_mm +
         std::sqrt(kArm_mm * kArm_mm - other_mm * other_mm - third_mm * third_mm);
}

TEST(DeltaCube, MovesEachAxisByItsOwnCoordinateAndByWhatTheArmsGiveWay) {
  const auto robot = delta_cube();
  const Eigen::VectorXd nominal = nominal_values(robot.parameters());
  std::mt19937 random(19);
  std::uniform_real_distribution<double> uniform(-2, 2);  // 4 x 4 x 4 mm, as published
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> p = {uniform(random), uniform(random), uniform(random)};
    const auto q = robot.predict(p, nominal).value;
    EXPECT_NEAR(q[0], motor_of(p[0], p[1], p[2]), 1e-11);
    EXPECT_NEAR(q[1], motor_of(p[1], p[2], p[0]), 1e-11);
    EXPECT_NEAR(q[2], motor_of(p[2], p[0], p[1]), 1e-11);
  }
}

TEST(DeltaCube, FindsThePoseOfItsMotors) {
  const auto robot = delta_cube();
  const Eigen::VectorXd nominal = nominal_values(robot.parameters());
  for (const auto& p :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1.9, -1.2, 0.4), Eigen::Vector3d(-2, -2, -2)}) {
    const Eigen::Vector3d q(motor_of(p[0], p[1], p[2]), motor_of(p[1], p[2], p[0]),
                            motor_of(p[2], p[0], p[1]));
    const auto pose = robot.pose_from_motor(q, nominal);
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_LT((*pose - p).norm(), 1e-10);
  }
}

TEST(DeltaCube, IsDecoupledAtPoseZero) {
  const auto robot = delta_cube();
  const Eigen::VectorXd nominal = nominal_values(robot.parameters());
  constexpr double kStep_mm = 1e-4;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> p(3, 0.0);
    p[static_cast<std::size_t>(axis)] = kStep_mm;
    const auto q = robot.predict(p, nominal).value;
    // The others give way by step^2 / 2L: 0.08 pm.
    for (int motor = 0; motor < 3; ++motor)
      EXPECT_NEAR(q[motor], motor == axis ? kStep_mm : 0, 1e-9);
  }
}

}  // namespace
}  // namespace driftwise::kinematics
