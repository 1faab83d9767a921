#include "server/kinematics/delta.h"

#include <Eigen/Geometry>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/kinematics/angles.h"

namespace driftwise::kinematics {
namespace {

using Vector = Eigen::Vector3d;

// Of one branch, in this order; the frame's six follow those of the third branch.
enum : int {
  kRadius,
  kAzimuth,
  kLength,
  kOffset,
  kTiltRadial,
  kTiltTangential,
  kScale,
  kPerBranch
};

struct Branch {
  Vector foot;                          // c: the carriage's joint at q = 0
  Vector direction;                     // u
  Vector radial, tangential;            // where the azimuth points, and to its left
  Vector radial_axis, tangential_axis;  // that the two tilts turn u about
  double radius, length, height, offset, gain;
};

Branch branch_of(const Eigen::VectorXd& values, int first, double side) {
  const auto at = [&](int which) { return values[first + which]; };
  Branch branch;
  const Eigen::AngleAxisd azimuth(rad_from_deg(at(kAzimuth)), Vector::UnitZ());
  branch.radial = azimuth * Vector::UnitX();
  branch.tangential = azimuth * Vector::UnitY();
  // Outwards for a positive radial tilt, to the left for a positive tangential one.
  const Eigen::AngleAxisd outwards(rad_from_deg(at(kTiltRadial)), branch.tangential);
  branch.radial_axis = branch.tangential;
  branch.tangential_axis = -(outwards * branch.radial);
  branch.direction = Eigen::AngleAxisd(rad_from_deg(at(kTiltTangential)), branch.tangential_axis) *
                     (outwards * Vector::UnitZ());
  branch.radius = at(kRadius);
  branch.length = at(kLength);
  branch.height = side * std::sqrt(branch.length * branch.length - branch.radius * branch.radius);
  branch.foot = branch.radius * branch.radial + branch.height * Vector::UnitZ();
  branch.offset = at(kOffset);
  branch.gain = 1 + 1e-6 * at(kScale);
  return branch;
}

// The carriage's place along its axis for the pose; NaN where the arm is too short.
double along(const Branch& branch, const Vector& pose, double side) {
  const Vector d = pose - branch.foot;
  const double projected = branch.direction.dot(d);
  return projected +
         side * std::sqrt(projected * projected - d.squaredNorm() + branch.length * branch.length);
}

// d(along)/d(parameters of the branch), and with respect to the pose, by the closing equation
// |p - c - q u|^2 = L^2.
struct BranchDerivatives {
  std::array<double, kPerBranch> own;
  Vector pose;
};

BranchDerivatives differentiate(const Branch& branch, const Vector& pose, double q) {
  const Vector arm = pose - branch.foot - q * branch.direction;
  const double down = 1 / arm.dot(branch.direction);
  const auto foot_moves = [&](const Vector& by) { return -down * arm.dot(by); };
  const auto axis_turns = [&](const Vector& about) {
    return -down * q * arm.dot(about.cross(branch.direction)) * kRadPerDeg;
  };
  BranchDerivatives result;
  result.pose = down * arm;
  result.own[kRadius] = foot_moves(branch.radial - branch.radius / branch.height * Vector::UnitZ());
  result.own[kAzimuth] =
      foot_moves(branch.radius * branch.tangential) * kRadPerDeg + axis_turns(Vector::UnitZ());
  result.own[kLength] =
      -down * branch.length + foot_moves(branch.length / branch.height * Vector::UnitZ());
  result.own[kOffset] = 1;
  result.own[kTiltRadial] = axis_turns(branch.radial_axis);
  result.own[kTiltTangential] = axis_turns(branch.tangential_axis);
  result.own[kScale] = 0;  // on what the scale reads, see predict
  return result;
}

Result<void> check_delta(const KinematicsDescription& description) {
  const auto bad = [](std::string sentence) {
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                "kinematics: " + std::move(sentence));
  };
  if (description.branches.size() != 3)
    return bad("found " + std::to_string(description.branches.size()) +
               " branches, expected three for a delta-vertical");
  for (const auto& branch : description.branches) {
    if (branch.motor.unit != "mm")
      return bad("found " + branch.motor.name() + ", expected a motor coordinate in mm");
    if (!(branch.radius_mm > 0) || !(branch.length_mm > branch.radius_mm))
      return bad("branch of " + branch.motor.name() + ": found radius_mm " +
                 digits_text(branch.radius_mm, 9) + " and length_mm " +
                 digits_text(branch.length_mm, 9) + ", expected 0 < radius_mm < length_mm");
  }
  return {};
}

}  // namespace

Result<Delta> Delta::create(const KinematicsDescription& description) {
  DRIFTWISE_RETURN_IF_ERROR(check_delta(description));
  Delta delta(description);
  delta.inputs_ = {{"x", "mm"}, {"y", "mm"}, {"z", "mm"}};
  int number = 0;
  for (const auto& branch : description.branches) {
    delta.outputs_.push_back(branch.motor);
    const std::string place = "branch" + std::to_string(++number) + ".";
    const double angle = deg_from_rad(kNaturalLength_mm / branch.length_mm);
    auto& all = delta.parameters_;
    all.push_back({place + "radius_mm", branch.radius_mm, kNaturalLength_mm, 0});
    all.push_back({place + "azimuth_deg", branch.azimuth_deg, angle, 1});
    all.push_back({place + "length_mm", branch.length_mm, kNaturalLength_mm, 0});
    all.push_back({place + "offset_mm", branch.offset_mm, kNaturalLength_mm, 0, true});
    all.push_back({place + "tilt_radial_deg", branch.tilt_radial_deg, angle, 3});
    all.push_back({place + "tilt_tangential_deg", branch.tilt_tangential_deg, angle, 3});
    all.push_back({place + "scale_ppm", branch.scale_ppm, 100, 2});
  }
  add_frame_parameters(delta.parameters_, description.frame, description.branches.front().length_mm,
                       4, false);
  DRIFTWISE_RETURN_IF_ERROR(hold(delta.parameters_, description.hold));
  return delta;
}

Prediction Delta::evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                           Derivatives derivatives) const {
  const double side = description_.carriages_above ? 1 : -1;
  const Frame frame(values.tail(kFrameParameters));
  const Vector measured(inputs[0], inputs[1], inputs[2]);
  const Vector pose = frame.inner(measured);
  Prediction prediction;
  prediction.value.resize(3);
  if (derivatives == Derivatives::yes) prediction.jacobian.setZero(3, values.size());
  for (int i = 0; i < 3; ++i) {
    const Branch branch = branch_of(values, i * kPerBranch, side);
    const double q = along(branch, pose, side);
    prediction.value[i] = (q + branch.offset) * branch.gain;
    if (derivatives == Derivatives::no) continue;
    const BranchDerivatives by = differentiate(branch, pose, q);
    for (int k = 0; k < kPerBranch; ++k)
      prediction.jacobian(i, i * kPerBranch + k) =
          branch.gain * by.own[static_cast<std::size_t>(k)];
    prediction.jacobian(i, i * kPerBranch + kScale) = 1e-6 * (q + branch.offset);
    prediction.jacobian.row(i).tail(kFrameParameters) =
        branch.gain * by.pose.transpose() * frame.inner_derivatives(measured);
  }
  return prediction;
}

Result<Vector> Delta::pose_from_motor(const Vector& q_mm, const Eigen::VectorXd& values) const {
  const double side = description_.carriages_above ? 1 : -1;
  std::array<Vector, 3> centre;
  std::array<double, 3> radius{};
  for (int i = 0; i < 3; ++i) {
    const Branch branch = branch_of(values, i * kPerBranch, side);
    const auto k = static_cast<std::size_t>(i);
    centre[k] = branch.foot + (q_mm[i] / branch.gain - branch.offset) * branch.direction;
    radius[k] = branch.length;
  }
  // Three spheres: along ex, ey from the first centre by the differences of their equations.
  const Vector first = centre[1] - centre[0], second = centre[2] - centre[0];
  const Vector normal = first.cross(second).normalized();
  const double width = first.norm();
  const Vector ex = first / width, ey = normal.cross(ex);
  const double i = ex.dot(second), j = ey.dot(second);
  const double x = (radius[0] * radius[0] - radius[1] * radius[1] + width * width) / (2 * width);
  const double y =
      (radius[0] * radius[0] - radius[2] * radius[2] + i * i + j * j - 2 * i * x) / (2 * j);
  const double height = std::sqrt(radius[0] * radius[0] - x * x - y * y);
  if (!std::isfinite(height))
    return fail(ErrorCode::out_of_range, reasons::kNoPose,
                "the arms do not meet at q = " + digits_text(q_mm[0], 9) + ", " +
                    digits_text(q_mm[1], 9) + ", " + digits_text(q_mm[2], 9) +
                    " mm: no pose belongs to these motor coordinates");
  const Vector away = normal.z() * side > 0 ? Vector(-normal) : normal;  // off the carriages
  return Frame(values.tail(kFrameParameters)).outer(centre[0] + x * ex + y * ey + height * away);
}

}  // namespace driftwise::kinematics
