#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/random.h"

namespace driftwise::foreign {

// One term of degree two or more of a robot's inverse geometry: s_motor += value * prod
// u_j^power_j.
struct GeometryTerm {
  int motor = 0;
  std::vector<int> powers;
  double value = 0.0;
};

// A robot drawn at random. Geometry is inverse: s = A u + higher terms, an exact polynomial, so
// that a baseline of the same degree describes it wholly.
//
// u: pose coordinates, normalised to [-1, 1] over the stroke. s: motor coordinates, likewise.
// Lengths are in mm and angles in arcsec; `half` and `motor_half` are the half strokes.
struct Robot {
  std::string kind;
  int axes = 0;
  std::vector<std::string> pose;
  std::vector<bool> pose_is_angle;
  std::vector<bool> motor_is_angle;
  Eigen::VectorXd half;
  Eigen::VectorXd motor_half;
  // Standard deviation of the pose noise, in the unit of the coordinate.
  Eigen::VectorXd sigma;
  // Zero at one end of the stroke rather than in its middle.
  bool zero_at_corner = false;
  int degree = 1;
  Eigen::MatrixXd linear;
  std::vector<GeometryTerm> higher;

  Eigen::VectorXd motor_of(const Eigen::VectorXd& u) const;
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& u) const;
  // Pose of a motor position by Newton's method.
  Eigen::VectorXd pose_of(const Eigen::VectorXd& s) const;
  double pose_value(int coordinate, double u) const;
  // Pose in the unit of each coordinate, normalised: the inverse of pose_value.
  Eigen::VectorXd normalised(const Eigen::VectorXd& values) const;
  double motor_value(int motor, double s) const;
};

// Kinds that are open, and those kept for a count on robots that were never run before.
const std::vector<std::string>& open_robots();
const std::vector<std::string>& reserved_robots();

// Robot of a kind ("gantry", "delta", "flexure", "linear", "hexapod") with geometry up to `degree`.
//
// askew_rad: rotation of the pose axes against the motor axes. reference: the fixed one-axis or
// three-axis robot with which one thing at a time is varied.
Robot make_robot(const std::string& kind, int degree, double askew_rad, bool reference,
                 Random& random);

// Bounds of the Jacobian of pose to motors (normalised units) that every robot of a data set keeps
// in its whole stroke: its determinant as a share of the middle's, and its condition.
inline constexpr double kLeastDeterminantShare = 0.2;
inline constexpr double kLargestCondition = 20.0;

// The robot is a machine: from the middle of the stroke one branch of poses leads to all its ends,
// the Jacobian is far from singular on it, and pose_of finds it.
//
// Paths: straight in the motors, to the corners of the stroke and, up to three axes, to the middles
// of its edges and faces. On them the bounds are a quarter narrower, so that they hold between the
// paths too. No random number is drawn.
bool regular_in_stroke(const Robot& robot);

}  // namespace driftwise::foreign
