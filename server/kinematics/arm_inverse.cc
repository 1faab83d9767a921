#include "server/kinematics/arm_inverse.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/kinematics/angles.h"

namespace driftwise::kinematics {
namespace {

using Eigen::Index;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr int kStarts = 256, kMostSteps = 60;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kConverged_mm = 1e-9;  // a picometre; turns times the reach count like lengths
constexpr double kAlike_rad = 1e-5;     // two solutions that are one
constexpr double kParallel = 0.05;      // sine between two axes
constexpr double kOfJoint1 = 0.3;       // share of the motion that does not move the tool

double nearest_turn(double angle, double to) {
  return angle - kTurn * std::round((angle - to) / kTurn);
}

class Solver {
 public:
  Solver(const SerialArm& arm, const Eigen::VectorXd& values, const WantedPose& wanted,
         std::span<const double> temperatures)
      : arm_(arm), values_(values), wanted_(wanted), inputs_(arm.inputs().size(), 0) {
    std::ranges::copy(temperatures, inputs_.begin() + static_cast<std::ptrdiff_t>(arm.joints()));
  }

  SerialArm::Posture posture(const Eigen::VectorXd& angles) {
    for (std::size_t j = 0; j < arm_.joints(); ++j)
      inputs_[j] = angles[static_cast<Index>(j)] / arm_.rad_per_unit(j);
    return arm_.posture(inputs_, values_);
  }

  // mm; the turn that is missing, times the reach.
  Eigen::VectorXd missing(const SerialArm::Posture& at) const {
    Eigen::VectorXd miss(rows());
    miss.head<3>() = wanted_.point_mm - at.tool.translation();
    if (wanted_.axes) {
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(*wanted_.axes * at.tool.linear().transpose()));
      miss.tail<3>() = arm_.reach_mm() * turn.angle() * turn.axis();
    }
    return miss;
  }

  Eigen::MatrixXd jacobian(const SerialArm::Posture& at) const {
    Eigen::MatrixXd scaled = at.jacobian.topRows(rows());
    if (rows() == 6) scaled.bottomRows(3) *= arm_.reach_mm();
    return scaled;
  }

  std::optional<Eigen::VectorXd> solve(Eigen::VectorXd angles) {
    auto at = posture(angles);
    Eigen::VectorXd miss = missing(at);
    double damping = 1e-3;
    for (int step = 0; step < kMostSteps; ++step) {
      if (miss.norm() < kConverged_mm) return angles;
      const Eigen::MatrixXd j = jacobian(at);
      Eigen::MatrixXd normal = j.transpose() * j;
      normal.diagonal().array() += damping * normal.diagonal().maxCoeff();
      const Eigen::VectorXd tried = angles + normal.ldlt().solve(j.transpose() * miss);
      const auto there = posture(tried);
      const Eigen::VectorXd left = missing(there);
      if (left.norm() < miss.norm()) {
        angles = tried, at = there, miss = left;
        damping = std::max(damping / 10, 1e-14);
      } else {
        damping *= 10;
        if (damping > 1e6) break;
      }
    }
    if (miss.norm() < 10 * kConverged_mm) return angles;
    return std::nullopt;
  }

 private:
  Index rows() const { return wanted_.axes ? 6 : 3; }

  const SerialArm& arm_;
  const Eigen::VectorXd& values_;
  const WantedPose& wanted_;
  std::vector<double> inputs_;
};

struct Singularity {
  const char *name, *what;
};

// By the axes where two of the wrist stand parallel, else by the joints that can turn without
// moving the tool.
Singularity singularity_of(const Matrix6X& jacobian, const Eigen::VectorXd& still) {
  const Index joints = jacobian.cols();
  if (joints == 6) {
    const Eigen::Vector3d fourth = jacobian.col(3).tail<3>(), sixth = jacobian.col(5).tail<3>();
    if (fourth.cross(sixth).norm() < kParallel)
      return {"wrist", "the axes of joints 4 and 6 are parallel"};
  }
  if (std::abs(still[0]) > kOfJoint1) return {"shoulder", "the wrist is over the axis of joint 1"};
  return {"elbow", "the arm is stretched or folded"};
}

// One solution at the turns of its joints that are nearest to the start within the limits.
struct Candidate {
  Eigen::VectorXd angles;
  std::uint32_t beyond = 0;
  double apart = 0;
};

Candidate placed(const SerialArm& arm, const Eigen::VectorXd& solution,
                 const Eigen::VectorXd& start) {
  Candidate result{solution, 0, 0};
  for (Index j = 0; j < start.size(); ++j) {
    const auto& link = arm.description().links[static_cast<std::size_t>(j)];
    const double low = rad_from_deg(link.min_deg), high = rad_from_deg(link.max_deg);
    double& angle = result.angles[j];
    angle = nearest_turn(angle, start[j]);
    if (angle < low) angle += kTurn * std::ceil((low - angle) / kTurn);
    if (angle > high) angle -= kTurn * std::ceil((angle - high) / kTurn);
    if (angle >= low && angle <= high) continue;
    angle = nearest_turn(angle, start[j]);
    result.beyond |= 1u << j;
  }
  result.apart = (result.angles - start).norm();
  return result;
}

// Within its limits, and so near to the start that no other solution can be nearer (Search).
bool is_nearest(const SerialArm& arm, Solver& solver, const Eigen::VectorXd& solution,
                const Eigen::VectorXd& start) {
  const Candidate one = placed(arm, solution, start);
  if (one.beyond != 0) return false;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(solver.jacobian(solver.posture(one.angles)) /
                                              arm.reach_mm());
  return one.apart < svd.singularValues().minCoeff() / (3 * static_cast<double>(start.size()));
}

}  // namespace

Result<JointSolution> nearest_joints(const SerialArm& arm, const Eigen::VectorXd& values,
                                     const WantedPose& wanted, std::span<const double> near,
                                     std::span<const double> temperatures, Search search) {
  const std::size_t joints = arm.joints();
  if (joints != 3 && joints != 6)
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                "found " + std::to_string(joints) +
                    " joints: an inverse solution needs 3 (a point) or 6 (a point and axes)");
  if ((joints == 6) != wanted.axes.has_value())
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                joints == 6 ? "six joints need rx, ry and rz beside x, y and z"
                            : "three joints reach a point: leave out rx, ry and rz");
  Solver solver(arm, values, wanted, temperatures);
  Eigen::VectorXd start(static_cast<Index>(joints));
  for (std::size_t j = 0; j < joints; ++j)
    start[static_cast<Index>(j)] = near[j] * arm.rad_per_unit(j);
  std::vector<Eigen::VectorXd> found;
  const auto take = [&](std::optional<Eigen::VectorXd> solution) {
    if (!solution) return;
    for (Index j = 0; j < start.size(); ++j)
      (*solution)[j] = nearest_turn((*solution)[j], start[j]);
    for (const auto& other : found) {
      double apart = 0;
      for (Index j = 0; j < start.size(); ++j)
        apart = std::max(apart, std::abs(nearest_turn(other[j] - (*solution)[j], 0)));
      if (apart < kAlike_rad) return;
    }
    found.push_back(std::move(*solution));
  };
  take(solver.solve(start));
  const bool certain = search == Search::until_certain && !found.empty() &&
                       is_nearest(arm, solver, found.front(), start);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(-std::numbers::pi, std::numbers::pi);
  for (int i = 0; i < kStarts && !certain; ++i) {
    Eigen::VectorXd from(start.size());
    for (double& angle : from) angle = anywhere(random);
    take(solver.solve(std::move(from)));
  }
  if (found.empty())
    return fail(ErrorCode::out_of_range, reasons::kNoPose,
                "no joint angles reach x " + digits_text(wanted.point_mm.x(), 6) + ", y " +
                    digits_text(wanted.point_mm.y(), 6) + ", z " +
                    digits_text(wanted.point_mm.z(), 6) +
                    " mm with these axes: the arm's reach is " + digits_text(arm.reach_mm(), 6) +
                    " mm from its base");
  std::vector<Candidate> candidates;
  for (const auto& one : found) candidates.push_back(placed(arm, one, start));
  const auto& [best, beyond, apart] = *std::ranges::min_element(
      candidates, {}, [](const Candidate& one) { return std::pair(one.beyond != 0, one.apart); });
  const auto at = solver.posture(best);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(solver.jacobian(at) / arm.reach_mm(),
                                              Eigen::ComputeThinU | Eigen::ComputeThinV);
  JointSolution result;
  result.least_motion = svd.singularValues().minCoeff();
  result.beyond = beyond;
  const auto singularity = singularity_of(at.jacobian, svd.matrixV().col(start.size() - 1));
  if (result.least_motion < kLeastMotion)
    return fail(ErrorCode::failed_precondition,
                std::string(reasons::kNoPose) + "(" + singularity.name + ")",
                std::string("near a singular pose (") + singularity.name + ": " + singularity.what +
                    "): a turn of the joints moves the tool by " +
                    digits_text(result.least_motion, 3) + " of the reach per radian, less than " +
                    digits_text(kLeastMotion, 3) +
                    "; choose another pose or other angles to be near to");
  for (std::size_t j = 0; j < joints; ++j)
    result.joints.push_back(best[static_cast<Index>(j)] / arm.rad_per_unit(j));
  const Eigen::VectorXd miss = solver.missing(at);
  result.miss_nm = nm_from_mm(miss.head<3>().norm());
  if (wanted.axes) result.miss_arcsec = arcsec_from_rad(miss.tail<3>().norm() / arm.reach_mm());
  result.solutions = certain ? 0 : static_cast<int>(found.size());
  return result;
}

Error beyond_limits(const SerialArm& arm, const JointSolution& solution) {
  std::string names, said;
  for (std::size_t j = 0; j < arm.joints(); ++j) {
    if ((solution.beyond >> j & 1) == 0) continue;
    const auto& link = arm.description().links[j];
    names += (names.empty() ? "" : "+") + link.motor.symbol;
    said += (said.empty() ? "" : ", ") + link.motor.symbol + " = " +
            digits_text(deg_from_rad(solution.joints[j] * arm.rad_per_unit(j)), 6) +
            " deg, limits " + digits_text(link.min_deg, 6) + " .. " + digits_text(link.max_deg, 6);
  }
  return {ErrorCode::out_of_range, std::string(reasons::kOutsideLimits) + "(" + names + ")",
          "each of " + std::to_string(solution.solutions) +
              " solutions has a joint beyond its limits; of the nearest: " + said +
              "; ask for another pose"};
}

}  // namespace driftwise::kinematics
