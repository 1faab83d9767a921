#pragma once
// Newton's method for a serial arm, from one start: N joints that bring the tool to a point (3) or
// to a point and axes (6). The model is that of SerialArm::posture(), errors of the joints in, with
// what stands still between two joints multiplied out once: a step costs about a microsecond.
//
// Source of the damping: Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108 (1986) 163.

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "server/kinematics/arm_inverse.h"
#include "server/kinematics/joint_errors.h"
#include "server/kinematics/serial_arm.h"

namespace driftwise::kinematics {

template <int N>
class ArmSolver {
 public:
  using Angles = Eigen::Matrix<double, N, 1>;  // rad
  using Square = Eigen::Matrix<double, N, N>;

  ArmSolver(const SerialArm& arm, const Eigen::VectorXd& values, const WantedPose& wanted,
            std::span<const double> temperatures)
      : arm_(arm),
        wanted_(wanted),
        temperatures_(temperatures.begin(), temperatures.end()),
        has_errors_(has_joint_errors(arm.description())) {
    const auto between = arm.between_joints(values);
    for (std::size_t j = 0; j <= N; ++j)
      turn_[j] = between[j].linear(), shift_[j] = between[j].translation();
  }

  // The tool's place at some angles, as far as a step needs it.
  struct There {
    Angles missing;                           // mm; the turn that is missing, times the reach
    Square jacobian;                          // mm per rad, likewise
    std::array<Eigen::Vector3d, N> axis, at;  // of each joint: its direction, a point on it
    Eigen::Vector3d tool;
  };
  There at(const Angles& angles) const { return at(angles, turns(angles)); }

  // Between which distances of two points the pose must have them: of the middle of joint 1 and,
  // with axes, joint 6, whose place the pose decides; else the point.
  struct Span {
    double apart_mm, least_mm, most_mm;
    bool reached() const {
      return apart_mm >= least_mm - kSlack_mm && apart_mm <= most_mm + kSlack_mm;
    }
  };
  Span span() const {
    Eigen::Vector3d end = wanted_.point_mm;
    if constexpr (N == 6) end -= *wanted_.axes * (turn_[N].transpose() * shift_[N]);
    // Joint 1 turns the first link about its axis: what lies along it stands still.
    const Eigen::Vector3d middle = shift_[0] + turn_[0] * Eigen::Vector3d(0, 0, shift_[1].z());
    double longest = shift_[1].template head<2>().norm(), all = longest;
    for (std::size_t j = 2; j <= (N == 6 ? 5u : 3u); ++j) {
      longest = std::max(longest, shift_[j].norm());
      all += shift_[j].norm();
    }
    return {(end - middle).norm(), 2 * longest - all, all};
  }
  std::optional<Angles> solve(Angles angles) const {
    const double near_mm = kRefreshed * arm_.reach_mm();
    Angles error = turns(angles);  // of the joints: hardly changes, and costs ten steps
    There here = at(angles, error);
    double miss = here.missing.norm(), damping = 1e-3, before = miss;
    for (int step = 1; step <= kMostSteps && miss >= kConverged_mm; ++step) {
      if (step % kLooked == 0) {  // a valley without a bottom at 0: its steps gain next to nothing
        if (miss > kGained * before) return std::nullopt;
        before = miss;
      }
      Square normal = here.jacobian.transpose() * here.jacobian;
      normal.diagonal().array() += damping * normal.diagonal().maxCoeff();
      const Angles tried = angles + normal.ldlt().solve(here.jacobian.transpose() * here.missing);
      const There there = at(tried, error);
      const double left = there.missing.norm();
      if (left < miss) {
        angles = tried, here = there, miss = left;
        damping = std::max(damping / 10, 1e-14);
        if (!has_errors_ || miss > near_mm) continue;
        error = turns(angles);
        here = at(angles, error);
        miss = here.missing.norm();
      } else {
        damping *= 10;
        if (damping > 1e6) break;
      }
    }
    if (miss < 10 * kConverged_mm) return angles;
    return std::nullopt;
  }

 private:
  static constexpr int kMostSteps = 60, kLooked = 8;
  static constexpr double kGained = 0.9;         // of the miss, in kLooked steps
  static constexpr double kConverged_mm = 1e-9;  // a picometre
  static constexpr double kRefreshed = 0.05;     // of the reach: from there errors count anew
  static constexpr double kSlack_mm = 1e-6;

  Angles turns(const Angles& angles) const {
    if (!has_errors_) return Angles::Zero();
    return joint_turns_rad(arm_.description(), {angles.data(), N}, temperatures_);
  }

  There at(const Angles& angles, const Angles& error) const {
    Eigen::Matrix3d axes = turn_[0];
    Eigen::Vector3d origin = shift_[0];
    There there;
    for (std::size_t j = 0; j < N; ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      there.axis[j] = axes.col(2), there.at[j] = origin;
      const double c = std::cos(angles[k] + error[k]), s = std::sin(angles[k] + error[k]);
      const Eigen::Vector3d first = axes.col(0), second = axes.col(1);
      axes.col(0) = c * first + s * second;
      axes.col(1) = c * second - s * first;
      origin += axes * shift_[j + 1];
      axes = (axes * turn_[j + 1]).eval();
    }
    there.tool = origin;
    there.missing.template head<3>() = wanted_.point_mm - origin;
    for (std::size_t j = 0; j < N; ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      there.jacobian.template block<3, 1>(0, k) =
          there.axis[j].cross(Eigen::Vector3d(origin - there.at[j]));
      if constexpr (N == 6)
        there.jacobian.template block<3, 1>(3, k) = arm_.reach_mm() * there.axis[j];
    }
    if constexpr (N == 6) {
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(*wanted_.axes * axes.transpose()));
      there.missing.template tail<3>() = arm_.reach_mm() * turn.angle() * turn.axis();
    }
    return there;
  }

  const SerialArm& arm_;
  const WantedPose& wanted_;
  std::vector<double> temperatures_;
  bool has_errors_;
  std::array<Eigen::Matrix3d, N + 1> turn_;  // between two joints, and how far
  std::array<Eigen::Vector3d, N + 1> shift_;
};

}  // namespace driftwise::kinematics
