#include "server/kinematics/arm_inverse.h"

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
#include "server/kinematics/arm_solver.h"

namespace driftwise::kinematics {
namespace {

using Eigen::Index;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kAlike_rad = 1e-5;  // two solutions that are one

// Starts of a search. Of eight arms by 24 drawn poses each at least 0.27 of all starts converge,
// and each solution has at least 0.03 of them, of poses with up to eight at least 0.05
// (arm_inverse_test holds the search against an exhaustive one).
constexpr int kMostStarts = 256, kStartsForNone = 48, kFewestStarts = 64, kStartsPerSolution = 16;

double nearest_turn(double angle, double to) {
  return angle - kTurn * std::round((angle - to) / kTurn);
}

// The most solutions that a pose can have. Where three neighbouring axes meet in a point or are
// parallel: 8 (D. L. Pieper, dissertation, Stanford 1968); small deviations from it add none. Of
// six joints in general: 16 (E. J. F. Primrose, Mech. Mach. Theory 21 (1986) 509).
std::size_t most_solutions(const SerialArm& arm) {
  constexpr double kNearly = 2e-3;  // of the reach; rad
  const auto& links = arm.description().links;
  if (links.size() == 3) return 4;
  const double near_mm = kNearly * arm.reach_mm();
  const auto parallel = [](const ArmLink& link) {
    return std::abs(std::sin(rad_from_deg(link.alpha_deg))) < kNearly &&
           std::abs(std::sin(rad_from_deg(link.beta_deg))) < kNearly;
  };
  for (std::size_t j = 0; j + 2 < links.size(); ++j) {
    const auto &first = links[j], &second = links[j + 1];
    const bool meet = std::abs(first.a_mm) < near_mm && std::abs(second.a_mm) < near_mm &&
                      std::abs(second.d_mm) < near_mm && !parallel(first) && !parallel(second);
    if (meet || (parallel(first) && parallel(second))) return 8;
  }
  return 16;
}

struct Singularity {
  const char *name, *what;
};

// By the factor of the Jacobian's determinant that is smallest beside its own scale, of those whose
// joints take part in `still`, the turn of the joints that moves the tool least. The factors are
// those of arms with a wrist; of another arm they name what it looks like most.
template <int N>
Singularity singularity_of(const ArmSolver<N>& solver, const typename ArmSolver<N>::There& there,
                           const typename ArmSolver<N>::Angles& still) {
  constexpr double kTakesPart = 0.05;
  struct Factor {
    Singularity singularity;
    double size;
    bool takes_part;
  };
  const auto turns = [&](Index joint) { return std::abs(still[joint]) > kTakesPart; };
  const auto across = [](const Eigen::Vector3d& way, const Eigen::Vector3d& axis) {
    return Eigen::Vector3d(way - way.dot(axis) * axis).normalized();
  };
  const Eigen::Vector3d &wrist = N == 6 ? there.at[N - 1] : there.tool,
                        &forearm = N == 6 ? there.at[N - 2] : there.tool;
  const auto &axis = there.axis, &at = there.at;
  const Eigen::Vector3d outwards = axis[0].cross(axis[1]).normalized();
  const Eigen::Vector3d upper_arm = across(at[2] - at[1], axis[2]);
  std::vector<Factor> factors = {{{"shoulder", "the wrist is over the axis of joint 1"},
                                  std::abs(outwards.dot(wrist - at[0])) / solver.span().most_mm,
                                  turns(0)},
                                 {{"elbow", "the arm is stretched or folded"},
                                  upper_arm.cross(across(forearm - at[2], axis[2])).norm(),
                                  turns(1) || turns(2)}};
  if constexpr (N == 6)
    factors.push_back({{"wrist", "the axes of joints 4 and 6 are parallel"},
                       axis[3].cross(axis[5]).norm(),
                       turns(3) && turns(5)});
  return std::ranges::min_element(
             factors, {}, [](const Factor& one) { return std::pair(!one.takes_part, one.size); })
      ->singularity;
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

// All of one search: N joints.
template <int N>
class JointSearch {
 public:
  using Angles = typename ArmSolver<N>::Angles;

  JointSearch(const SerialArm& arm, const Eigen::VectorXd& values, const WantedPose& wanted,
              std::span<const double> near, std::span<const double> temperatures)
      : arm_(arm), wanted_(wanted), solver_(arm, values, wanted, temperatures) {
    for (std::size_t j = 0; j < N; ++j)
      start_[static_cast<Index>(j)] = near[j] * arm.rad_per_unit(j);
  }

  bool reached() const { return solver_.span().reached(); }

  // Whether the first solution is the nearest.
  bool begin() {
    take(solver_.solve(start_));
    if (found_.empty()) return false;
    const Candidate one = placed(arm_, found_.front(), start_);
    if (one.beyond != 0) return false;
    return one.apart < least_motion(Angles(one.angles)) / (3.0 * N);
  }

  void search() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> anywhere(-std::numbers::pi, std::numbers::pi);
    const std::size_t most = most_solutions(arm_);
    for (int i = 0; i < kMostStarts && found_.size() < most; ++i) {
      const int enough =
          found_.empty() ? kStartsForNone : kStartsPerSolution * static_cast<int>(found_.size());
      if (i >= std::max(enough, found_.empty() ? 0 : kFewestStarts)) break;
      Angles from;
      for (double& angle : from) angle = anywhere(random);
      take(solver_.solve(from));
    }
  }

  Result<JointSolution> nearest(bool certain) const {
    if (found_.empty()) return unreached("the search of the joints' angles found none");
    std::vector<Candidate> candidates;
    for (const auto& one : found_) candidates.push_back(placed(arm_, one, start_));
    const auto& best = *std::ranges::min_element(
        candidates, {}, [](const Candidate& one) { return std::pair(one.beyond != 0, one.apart); });
    const auto there = solver_.at(Angles(best.angles));
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(there.jacobian / arm_.reach_mm()),
                                                Eigen::ComputeThinU | Eigen::ComputeThinV);
    JointSolution result;
    result.least_motion = svd.singularValues().minCoeff();
    result.beyond = best.beyond;
    if (result.least_motion < kLeastMotion) {
      const auto singularity = singularity_of<N>(solver_, there, Angles(svd.matrixV().col(N - 1)));
      return fail(ErrorCode::failed_precondition,
                  std::string(reasons::kNoPose) + "(" + singularity.name + ")",
                  std::string("near a singular pose (") + singularity.name + ": " +
                      singularity.what + "): a turn of the joints moves the tool by " +
                      digits_text(result.least_motion, 3) + " of the reach per radian, less than " +
                      digits_text(kLeastMotion, 3) +
                      "; choose another pose or other angles to be near to");
    }
    for (std::size_t j = 0; j < N; ++j)
      result.joints.push_back(best.angles[static_cast<Index>(j)] / arm_.rad_per_unit(j));
    result.miss_nm = nm_from_mm(there.missing.template head<3>().norm());
    if constexpr (N == 6)
      result.miss_arcsec =
          arcsec_from_rad(there.missing.template tail<3>().norm() / arm_.reach_mm());
    result.solutions = certain ? 0 : static_cast<int>(found_.size());
    return result;
  }

  tl::unexpected<Error> beyond_reach() const {
    const auto span = solver_.span();
    return unreached(std::string(N == 6 ? "joint 6" : "the point") + " would stand " +
                     digits_text(span.apart_mm, 6) +
                     " mm from the middle of joint 1, and the links between them reach from " +
                     digits_text(std::max(span.least_mm, 0.0), 6) + " to " +
                     digits_text(span.most_mm, 6) + " mm");
  }

 private:
  void take(std::optional<Angles> solution) {
    if (!solution) return;
    for (Index j = 0; j < N; ++j) (*solution)[j] = nearest_turn((*solution)[j], start_[j]);
    for (const auto& other : found_) {
      double apart = 0;
      for (Index j = 0; j < N; ++j)
        apart = std::max(apart, std::abs(nearest_turn(other[j] - (*solution)[j], 0)));
      if (apart < kAlike_rad) return;
    }
    found_.push_back(*solution);
  }

  double least_motion(const Angles& angles) const {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
        Eigen::MatrixXd(solver_.at(angles).jacobian / arm_.reach_mm()));
    return svd.singularValues().minCoeff();
  }

  tl::unexpected<Error> unreached(const std::string& why) const {
    const auto& point = wanted_.point_mm;
    return fail(ErrorCode::out_of_range, reasons::kNoPose,
                "no joint angles reach x " + digits_text(point.x(), 6) + ", y " +
                    digits_text(point.y(), 6) + ", z " + digits_text(point.z(), 6) + " mm" +
                    (wanted_.axes ? " with these axes" : "") + ": " + why +
                    "; ask for a pose within the arm's reach, which is " +
                    digits_text(arm_.reach_mm(), 6) + " mm from its base");
  }

  const SerialArm& arm_;
  const WantedPose& wanted_;
  ArmSolver<N> solver_;
  Angles start_;
  std::vector<Angles> found_;
};

template <int N>
Result<JointSolution> searched(JointSearch<N> search, Search how) {
  if (!search.reached()) return search.beyond_reach();
  const bool certain = search.begin() && how == Search::until_certain;
  if (!certain) search.search();
  return search.nearest(certain);
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
  return joints == 6 ? searched(JointSearch<6>(arm, values, wanted, near, temperatures), search)
                     : searched(JointSearch<3>(arm, values, wanted, near, temperatures), search);
}

bool needs_search(const SerialArm& arm, const Eigen::VectorXd& values, const WantedPose& wanted,
                  std::span<const double> near, std::span<const double> temperatures) {
  const auto asked = [](auto search) { return search.reached() && !search.begin(); };
  return arm.joints() == 6 ? asked(JointSearch<6>(arm, values, wanted, near, temperatures))
                           : asked(JointSearch<3>(arm, values, wanted, near, temperatures));
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
