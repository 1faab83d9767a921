#include "server/kinematics/serial_arm.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/kinematics/angles.h"
#include "server/kinematics/frame.h"
#include "server/kinematics/joint_errors.h"

namespace driftwise::kinematics {
namespace {

constexpr double kParallel_deg = 5;
constexpr std::size_t kMostLinks = 9;

bool nearly_parallel(double alpha_deg) {
  return std::abs(std::sin(rad_from_deg(alpha_deg))) < std::sin(rad_from_deg(kParallel_deg));
}

// From the first joint to the tool, stretched out.
double reach_of_arm_mm(const KinematicsDescription& arm) {
  double reach = std::abs(arm.tool_x_mm) + std::abs(arm.tool_y_mm) + std::abs(arm.tool_z_mm);
  for (const auto& link : arm.links) reach += std::abs(link.a_mm) + std::abs(link.d_mm);
  return std::max(reach, 1.0);
}

Result<void> check_arm(const KinematicsDescription& description) {
  const auto bad = [](std::string sentence) {
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                "kinematics: " + std::move(sentence));
  };
  if (description.links.empty() || description.links.size() > kMostLinks)
    return bad("found " + std::to_string(description.links.size()) +
               " links, expected 1 to 9 for a serial-arm");
  for (const auto& link : description.links)
    if (link.motor.unit != "rad" && link.motor.unit != "deg")
      return bad("found " + link.motor.name() + ", expected a joint angle in rad or deg");
  const bool masses = has_masses(description);
  for (const auto& link : description.links) {
    if (masses ? link.errors.sag_urad_per_m != 0 : link.errors.sag_urad_per_newton_m != 0)
      return bad(masses ? "found sag_urad_per_m in an arm with masses, expected "
                          "sag_urad_per_newton_m"
                        : "found sag_urad_per_newton_m in an arm without masses, expected "
                          "sag_urad_per_m, or mass_kg in its links");
    const auto& channel = link.errors.drift_channel;
    if (!channel.symbol.empty() && channel.unit != "degC" && channel.unit != "K")
      return bad("found drift_channel " + channel.name() + ", expected a temperature");
    if (channel.symbol.empty() && link.errors.drift_arcsec_per_k != 0)
      return bad("found drift_arcsec_per_k without drift_channel, expected both");
    if (!(link.min_deg < link.max_deg))
      return bad("limits of " + link.motor.symbol + ": found min_deg " +
                 digits_text(link.min_deg, 6) + " and max_deg " + digits_text(link.max_deg, 6) +
                 ", expected min_deg below max_deg");
  }
  if (Eigen::Vector3d(description.gravity.data()).norm() < 1e-6)
    return bad("found gravity of no direction, expected such as [0, 0, -1]");
  return {};
}

// A turn of the columns of axes about one of them: cheaper than a product of matrices.
void turn_axes(Eigen::Matrix3d& axes, int about, double angle) {
  const int u = (about + 1) % 3, v = (about + 2) % 3;
  const double c = std::cos(angle), s = std::sin(angle);
  const Eigen::Vector3d first = axes.col(u), second = axes.col(v);
  axes.col(u) = c * first + s * second;
  axes.col(v) = c * second - s * first;
}

}  // namespace

Result<SerialArm> SerialArm::create(const KinematicsDescription& description) {
  DRIFTWISE_RETURN_IF_ERROR(check_arm(description));
  SerialArm arm(description);
  auto& all = arm.parameters_;
  auto& chain = arm.chain_;
  const double reach = reach_of_arm_mm(description);
  arm.reach_mm_ = reach;
  arm.has_errors_ = has_joint_errors(description);
  const double angle = deg_from_rad(kNaturalLength_mm / reach);
  const auto parameter = [&](const std::string& name, double nominal, double natural, int rank) {
    all.push_back({name, nominal, natural, rank});
    return static_cast<int>(all.size()) - 1;
  };

  add_frame_parameters(all, description.frame, reach, 0, true);
  for (int axis : {0, 1, 2}) chain.push_back({Kind::shift, axis, axis, 0, -1});
  for (int axis : {2, 1, 0}) chain.push_back({Kind::turn, axis, 3 + axis, 0, -1});
  int number = 0;
  for (const auto& link : description.links) {
    const std::string place = "link" + std::to_string(++number) + ".";
    // Behind the last link there is no axis that could be parallel.
    const bool hayati = nearly_parallel(link.alpha_deg) && &link != &description.links.back();
    const int theta = parameter(place + "theta_deg", link.theta_deg, angle, 2);
    chain.push_back({Kind::turn, 2, theta, 0, number - 1});
    if (hayati)
      chain.push_back({Kind::shift, 2, -1, link.d_mm, -1});
    else
      chain.push_back(
          {Kind::shift, 2, parameter(place + "d_mm", link.d_mm, kNaturalLength_mm, 2), 0, -1});
    chain.push_back(
        {Kind::shift, 0, parameter(place + "a_mm", link.a_mm, kNaturalLength_mm, 2), 0, -1});
    chain.push_back(
        {Kind::turn, 0, parameter(place + "alpha_deg", link.alpha_deg, angle, 2), 0, -1});
    if (hayati)
      chain.push_back(
          {Kind::turn, 1, parameter(place + "beta_deg", link.beta_deg, angle, 3), 0, -1});
    else if (link.beta_deg != 0)
      chain.push_back({Kind::turn, 1, -1, rad_from_deg(link.beta_deg), -1});
    arm.inputs_.push_back(link.motor);
    arm.rad_per_unit_.push_back(link.motor.unit == "deg" ? kRadPerDeg : 1.0);
  }
  for (const auto& channel : drift_channels(description)) arm.inputs_.push_back(channel);
  const std::array<std::pair<const char*, double>, 3> tool = {
      {{"tool.x_mm", description.tool_x_mm},
       {"tool.y_mm", description.tool_y_mm},
       {"tool.z_mm", description.tool_z_mm}}};
  for (int axis : {0, 1, 2}) {
    const auto& [name, nominal] = tool[static_cast<std::size_t>(axis)];
    chain.push_back({Kind::shift, axis, parameter(name, nominal, kNaturalLength_mm, 1), 0, -1});
  }
  arm.outputs_ = {{"x", "mm"}, {"y", "mm"}, {"z", "mm"}};
  DRIFTWISE_RETURN_IF_ERROR(hold(all, description.hold));
  return arm;
}

std::vector<double> SerialArm::motions(std::span<const double> inputs,
                                       const Eigen::VectorXd& values) const {
  std::array<double, kMostLinks> angles{};
  for (std::size_t j = 0; j < joints(); ++j) angles[j] = inputs[j] * rad_per_unit_[j];
  if (has_errors_) {
    const Eigen::VectorXd turns =
        joint_turns_rad(description_, {angles.data(), joints()}, inputs.subspan(joints()));
    for (std::size_t j = 0; j < joints(); ++j) angles[j] += turns[static_cast<Eigen::Index>(j)];
  }
  std::vector<double> all;
  all.reserve(chain_.size());
  for (const auto& element : chain_) {
    double by = element.parameter < 0 ? element.fixed : values[element.parameter];
    if (element.parameter >= 0 && element.kind == Kind::turn) by = rad_from_deg(by);
    if (element.joint >= 0) by += angles[static_cast<std::size_t>(element.joint)];
    all.push_back(by);
  }
  return all;
}

// Each parameter turns or shifts everything behind it about or along one axis of the frame reached
// so far, so its column is axis x (point - origin), or the axis itself.
Prediction SerialArm::evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                               Derivatives derivatives) const {
  struct Passed {
    Eigen::Vector3d axis, origin;
  };
  std::array<Passed, kMostParameters> passed;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  const auto motion = motions(inputs, values);
  for (std::size_t e = 0; e < chain_.size(); ++e) {
    const auto& element = chain_[e];
    if (element.parameter >= 0)
      passed[static_cast<std::size_t>(element.parameter)] = {axes.col(element.axis), origin};
    if (element.kind == Kind::turn)
      turn_axes(axes, element.axis, motion[e]);
    else
      origin += motion[e] * axes.col(element.axis);
  }
  Prediction prediction;
  prediction.value = origin;
  if (derivatives == Derivatives::no) return prediction;
  prediction.jacobian.resize(3, values.size());
  for (const auto& element : chain_) {
    if (element.parameter < 0) continue;
    const auto& [axis, from] = passed[static_cast<std::size_t>(element.parameter)];
    if (element.kind == Kind::turn)
      prediction.jacobian.col(element.parameter) = kRadPerDeg * axis.cross(origin - from);
    else
      prediction.jacobian.col(element.parameter) = axis;
  }
  return prediction;
}

std::vector<Eigen::Isometry3d> SerialArm::between_joints(const Eigen::VectorXd& values) const {
  std::vector<Eigen::Isometry3d> all(1, Eigen::Isometry3d::Identity());
  for (const auto& element : chain_) {
    double by = element.parameter < 0 ? element.fixed : values[element.parameter];
    if (element.parameter >= 0 && element.kind == Kind::turn) by = rad_from_deg(by);
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(element.axis);
    if (element.joint >= 0) all.push_back(Eigen::Isometry3d::Identity());
    if (element.kind == Kind::turn)
      all.back().rotate(Eigen::AngleAxisd(by, axis));
    else
      all.back().translate(by * axis);
  }
  return all;
}

SerialArm::Posture SerialArm::posture(std::span<const double> inputs, const Eigen::VectorXd& values,
                                      Derivatives by_parameters) const {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Posture result;
  if (by_parameters == Derivatives::yes) result.by_parameters.setZero(6, values.size());
  Eigen::Matrix3Xd joint_axes(3, static_cast<Eigen::Index>(joints())), joint_origins = joint_axes;
  const auto motion = motions(inputs, values);
  for (std::size_t e = 0; e < chain_.size(); ++e) {
    const auto& element = chain_[e];
    if (element.joint >= 0) {
      joint_axes.col(element.joint) = axes.col(element.axis);
      joint_origins.col(element.joint) = origin;
    }
    // Until the end of the chain is known: the axis, and of a turn where it stands.
    if (by_parameters == Derivatives::yes && element.parameter >= 0)
      result.by_parameters.col(element.parameter) << origin, axes.col(element.axis);
    if (element.kind == Kind::turn)
      turn_axes(axes, element.axis, motion[e]);
    else
      origin += motion[e] * axes.col(element.axis);
  }
  if (by_parameters == Derivatives::yes)
    for (const auto& element : chain_) {
      if (element.parameter < 0) continue;
      auto column = result.by_parameters.col(element.parameter);
      const Eigen::Vector3d from = column.head<3>(), axis = column.tail<3>();
      if (element.kind == Kind::turn)
        column << kRadPerDeg * axis.cross(Eigen::Vector3d(origin - from)), kRadPerDeg * axis;
      else
        column << axis, Eigen::Vector3d::Zero();
    }
  result.tool = Eigen::Isometry3d::Identity();
  result.tool.linear() = axes;
  result.tool.translation() = origin;
  result.jacobian.resize(6, joint_axes.cols());
  for (Eigen::Index j = 0; j < joint_axes.cols(); ++j) {
    result.jacobian.col(j).head<3>() =
        joint_axes.col(j).cross(Eigen::Vector3d(origin - joint_origins.col(j)));
    result.jacobian.col(j).tail<3>() = joint_axes.col(j);
  }
  return result;
}

}  // namespace driftwise::kinematics
