#include "server/compensation/forward_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "server/compensation/basis_values.h"
#include "server/compensation/dot.h"
#include "server/compensation/geometry_law.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::compensation {
namespace {

constexpr int kMaxSteps = 60;
constexpr double kFarthest = 3;     // half widths of the domain from its middle
constexpr double kLongestStep = 1;  // half widths: keeps a curved model's first step inside
// A pose whose motor coordinates agree to a ten-thousandth of a nanometre.
constexpr double kAgreesMm = 1e-10;

struct Unknown {
  Variable variable;
  double middle, half_width;
};

std::vector<Unknown> unknowns_of(const Snapshot& snapshot, const TargetRequest& stated) {
  std::vector<Unknown> unknowns;
  for (std::size_t v = 0; v < kVariables; ++v) {
    const auto variable = static_cast<Variable>(v);
    if (variable == Variable::force || (snapshot.needed & ~stated.given & bit(variable)) == 0)
      continue;
    Unknown unknown{variable, 0, 1};
    for (const auto& input : snapshot.inputs)
      if (input.variable == variable && input.max > input.min)
        unknown = {variable, 0.5 * (input.min + input.max), 0.5 * (input.max - input.min)};
    unknowns.push_back(unknown);
  }
  return unknowns;
}

std::string names_of(const std::vector<Unknown>& unknowns) {
  std::string names;
  for (const auto& unknown : unknowns)
    names += (names.empty() ? "" : ", ") + channel_of(unknown.variable).name();
  return names;
}

Error not_square(const Snapshot& snapshot, const std::vector<Unknown>& unknowns) {
  std::string outputs;
  for (const auto& output : snapshot.outputs)
    outputs += (outputs.empty() ? "" : ", ") + output.channel.name();
  const bool too_many = unknowns.size() > snapshot.outputs.size();
  return {ErrorCode::invalid_argument, reasons::kNotSquare,
          "model " + std::to_string(snapshot.model.value) + " gives " +
              std::to_string(snapshot.outputs.size()) + " motor coordinates (" + outputs +
              ") and " + std::to_string(unknowns.size()) +
              " coordinates of the pose are to be solved for (" +
              (unknowns.empty() ? "none" : names_of(unknowns)) + "): state " +
              (too_many ? std::to_string(unknowns.size() - snapshot.outputs.size()) + " of them"
                        : std::string("fewer"))};
}

// Motor coordinates at a pose, and their slopes: outputs x unknowns, mm per unit of the request.
void model_at(const Snapshot& snapshot, const TargetRequest& pose,
              const std::vector<Unknown>& unknowns, Eigen::VectorXd& q_mm,
              Eigen::MatrixXd& slopes) {
  const Columns columns = columns_of(snapshot, pose.value);
  Basis basis;
  fill_basis(snapshot, columns, basis);
  const std::size_t size = snapshot.basis_size();
  for (std::size_t i = 0; i < snapshot.outputs.size(); ++i)
    q_mm[static_cast<Eigen::Index>(i)] =
        dot(snapshot.outputs[i].coefficients_mm.data(), basis.b.data(), size);
  Basis derived;
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    fill_slope(snapshot, columns, basis, unknowns[j].variable, derived);
    for (std::size_t i = 0; i < snapshot.outputs.size(); ++i)
      slopes(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          dot(snapshot.outputs[i].coefficients_mm.data(), derived.b.data(), size);
  }
}

Error no_pose(const ForwardRequest& request, const Snapshot& snapshot, const std::string& why) {
  std::string asked;
  for (std::size_t i = 0; i < request.q_mm.size(); ++i) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.7g", request.q_mm[i]);
    asked += (asked.empty() ? "" : ", ") + snapshot.outputs[i].channel.name() + " = " + digits;
  }
  return {ErrorCode::failed_precondition, reasons::kNoConvergence,
          "no pose found for " + asked + ": " + why};
}

// Standard uncertainties of coordinates of a pose, request's units. inverse: coordinates by motor
// coordinates, per mm. An error that motors share moves them together, with its signs.
Eigen::VectorXd u_of_pose(const Snapshot& snapshot, const TargetRequest& pose,
                          const Eigen::MatrixXd& inverse) {
  const ErrorParts parts = error_parts(snapshot, pose);
  const auto size = static_cast<Eigen::Index>(parts.own_nm2.size());
  if (size != inverse.cols())
    return Eigen::VectorXd::Constant(inverse.rows(), std::numeric_limits<double>::quiet_NaN());
  Eigen::VectorXd variance =
      inverse.cwiseAbs2() * Eigen::Map<const Eigen::VectorXd>(parts.own_nm2.data(), size);
  for (const auto& error : parts.shared_nm)
    variance += (inverse * Eigen::Map<const Eigen::VectorXd>(error.data(), size)).cwiseAbs2();
  return variance.cwiseSqrt() * (parts.factor / kNmPerMm);
}

// Standard uncertainties where the law gives none: those of the motor coordinates through the
// inverse of the slopes.
void add_u_by_slopes(const Snapshot& snapshot, TargetRequest pose, ForwardPose& result) {
  constexpr double kStep = 1e-3;  // mm
  const auto size = static_cast<Eigen::Index>(result.coordinates.size());
  if (result.target.outputs != result.coordinates.size()) return;
  pose.with_uncertainty = false;
  Eigen::MatrixXd slopes(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    auto& one = pose.value[static_cast<std::size_t>(
        result.coordinates[static_cast<std::size_t>(j)].variable)];
    const double at = one;
    one = at + kStep;
    const auto there = compute_target(snapshot, pose);
    one = at;
    for (Eigen::Index i = 0; i < size; ++i)
      slopes(i, j) = (there.q_mm[static_cast<std::size_t>(i)] -
                      result.target.q_mm[static_cast<std::size_t>(i)]) /
                     kStep;
  }
  const Eigen::MatrixXd inverse = slopes.inverse();
  const Eigen::VectorXd u = u_of_pose(snapshot, pose, inverse);
  for (Eigen::Index j = 0; j < size; ++j) result.coordinates[static_cast<std::size_t>(j)].u = u[j];
}

// Of a geometry: what the polynomial adds reads no pose, so it comes off first.
Result<ForwardPose> pose_by_law(const Snapshot& snapshot, const ForwardRequest& request) {
  const std::uint32_t unstated = snapshot.needed & bit(Variable::force) & ~request.stated.given;
  if (unstated != 0 || !snapshot.changed_parts.empty()) {
    Target target;
    target.refusal = unstated != 0 ? Refusal::missing_coordinate : Refusal::configuration_changed;
    for (std::size_t i = 0; i < snapshot.inputs.size(); ++i)
      if (snapshot.inputs[i].variable == Variable::force) target.missing |= std::uint64_t{1} << i;
    return tl::unexpected(refusal_error(snapshot, target));
  }
  if (request.q_mm.size() != snapshot.outputs.size())
    return fail(ErrorCode::invalid_argument, reasons::kMissingValue,
                "expected " + std::to_string(snapshot.outputs.size()) +
                    " motor coordinates, found " + std::to_string(request.q_mm.size()));
  Basis basis;
  fill_basis(snapshot, request.stated, basis);
  std::vector<double> q;
  for (std::size_t i = 0; i < request.q_mm.size(); ++i) {
    q.push_back(request.q_mm[i] - dot(snapshot.outputs[i].coefficients_mm.data(), basis.b.data(),
                                      snapshot.basis_size()));
    if (!std::isfinite(q.back()))
      return fail(ErrorCode::invalid_argument, reasons::kNotFinite,
                  snapshot.outputs[i].channel.name() +
                      " or the force is not a finite number: state it in the unit of its name");
  }
  DRIFTWISE_TRY(const auto found, snapshot.geometry->law->pose_of(q, *snapshot.geometry));
  ForwardPose result;
  TargetRequest pose = request.stated;
  pose.show_unreachable = true;
  for (std::size_t k = 0; k < found.variables.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    result.coordinates.push_back({found.variables[k], found.pose[at], found.u[at]});
    pose.set(found.variables[k], found.pose[at]);
  }
  // The motors as stated: another solution of the pose has other flags, and a singular one none.
  const auto judged = judge_motors(snapshot, pose, request.q_mm);
  result.target = judged.target;
  if (result.target.refusal != Refusal::none)
    return tl::unexpected(refusal_error(snapshot, result.target));
  if (snapshot.unjudged) return result;
  if (!snapshot.geometry->law->absolute()) {
    add_u_by_slopes(snapshot, pose, result);
  } else {  // an arm's own: joints err together, and nothing measured its axes
    for (auto& coordinate : result.coordinates) coordinate.u *= judged.factor;
  }
  return result;
}

}  // namespace

Result<ForwardPose> forward_pose(const Snapshot& snapshot, const ForwardRequest& request) {
  if (snapshot.geometry) return pose_by_law(snapshot, request);
  TargetRequest pose = request.stated;
  pose.show_unreachable = true;
  const auto unknowns = unknowns_of(snapshot, pose);
  for (const auto& unknown : unknowns) pose.set(unknown.variable, unknown.middle);
  // No model, an unanswered change of the cell, a force that is not stated.
  if (const auto first = compute_target(snapshot, pose); first.refusal != Refusal::none &&
                                                         first.refusal != Refusal::outside_domain &&
                                                         first.refusal != Refusal::outside_limits)
    return tl::unexpected(refusal_error(snapshot, first));
  if (unknowns.size() != snapshot.outputs.size() || unknowns.empty())
    return tl::unexpected(not_square(snapshot, unknowns));
  if (request.q_mm.size() != snapshot.outputs.size())
    return fail(ErrorCode::invalid_argument, reasons::kMissingValue,
                "expected " + std::to_string(snapshot.outputs.size()) +
                    " motor coordinates, found " + std::to_string(request.q_mm.size()));
  if (!std::all_of(request.q_mm.begin(), request.q_mm.end(),
                   [](double q) { return std::isfinite(q); }))
    return fail(ErrorCode::invalid_argument, reasons::kNotFinite,
                "a motor coordinate is not a finite number: state it in mm");

  const auto size = static_cast<Eigen::Index>(unknowns.size());
  const Eigen::VectorXd wanted = Eigen::Map<const Eigen::VectorXd>(request.q_mm.data(), size);
  Eigen::VectorXd q_mm(size);
  Eigen::MatrixXd slopes(size, size), inverse;
  Eigen::VectorXd half_widths(size);
  for (Eigen::Index j = 0; j < size; ++j)
    half_widths[j] = unknowns[static_cast<std::size_t>(j)].half_width;
  bool agreed = false;
  for (int step = 0; step < kMaxSteps; ++step) {
    model_at(snapshot, pose, unknowns, q_mm, slopes);
    // In half widths, so that a rank is judged where millimetres meet arcseconds.
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(slopes * half_widths.asDiagonal());
    if (!lu.isInvertible())
      return tl::unexpected(no_pose(request, snapshot, "the model's slopes are singular there"));
    inverse = half_widths.asDiagonal() * lu.inverse();
    if (agreed) break;  // one more step after agreement, and the slopes there
    const double error_mm = (wanted - q_mm).cwiseAbs().maxCoeff();
    agreed = error_mm <= kAgreesMm;
    Eigen::VectorXd change = lu.solve(wanted - q_mm);
    const double longest = change.cwiseAbs().maxCoeff();
    if (!std::isfinite(longest)) break;
    if (longest > kLongestStep) change *= kLongestStep / longest;
    for (std::size_t j = 0; j < unknowns.size(); ++j) {
      double& value = pose.value[static_cast<std::size_t>(unknowns[j].variable)];
      const double farthest = kFarthest * unknowns[j].half_width;
      value = std::clamp(value + change[static_cast<Eigen::Index>(j)] * unknowns[j].half_width,
                         unknowns[j].middle - farthest, unknowns[j].middle + farthest);
    }
  }
  if (!agreed)
    return tl::unexpected(no_pose(request, snapshot,
                                  "none within three half widths of the fitted domain gives them; "
                                  "is the robot where the model was fitted?"));

  ForwardPose found;
  found.target = compute_target(snapshot, pose);
  if (found.target.refusal != Refusal::none)
    return tl::unexpected(refusal_error(snapshot, found.target));
  const Eigen::VectorXd u = u_of_pose(snapshot, pose, inverse);
  for (std::size_t j = 0; j < unknowns.size(); ++j)
    found.coordinates.push_back({unknowns[j].variable,
                                 pose.value[static_cast<std::size_t>(unknowns[j].variable)],
                                 u[static_cast<Eigen::Index>(j)]});
  return found;
}

}  // namespace driftwise::compensation
