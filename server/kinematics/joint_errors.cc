#include "server/kinematics/joint_errors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/kinematics/angles.h"

namespace driftwise::kinematics {
namespace {

constexpr double kGravity_m_per_s2 = 9.80665;  // standard, CGPM 1901
constexpr double kMPerMm = 1e-3, kRadPerUrad = 1e-6;

bool reads_gravity(const ArmLink& link) {
  return link.errors.sag_urad_per_m != 0 || link.errors.sag_urad_per_newton_m != 0 ||
         link.errors.play_arcsec != 0;
}

// One piece of what the joints carry: from joint `from` on it moves with the arm.
struct Piece {
  std::size_t from;
  double weight;  // kg, or mm of length
  Eigen::Vector3d centre_mm;
};

struct JointAxis {
  Eigen::Vector3d origin_mm, direction;
};

}  // namespace

bool has_masses(const KinematicsDescription& arm) {
  return arm.tool_mass_kg != 0 ||
         std::ranges::any_of(arm.links, [](const ArmLink& link) { return link.mass_kg != 0; });
}

bool has_joint_errors(const KinematicsDescription& arm) {
  return std::ranges::any_of(arm.links,
                             [](const ArmLink& link) { return !(link.errors == JointErrors{}); });
}

Eigen::VectorXd gravity_torques(const KinematicsDescription& arm,
                                std::span<const double> angles_rad) {
  const bool masses = has_masses(arm);
  std::vector<JointAxis> joints;
  std::vector<Piece> pieces;
  Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
  const auto add_bar = [&](std::size_t joint, const Eigen::Vector3d& along_mm) {
    const Eigen::Vector3d from = at.translation(), to = at * along_mm;
    if (!masses) pieces.push_back({joint, (to - from).norm(), (from + to) / 2});
  };
  for (std::size_t j = 0; j < arm.links.size(); ++j) {
    const auto& link = arm.links[j];
    joints.push_back({at.translation(), at.linear().col(2)});
    at.rotate(
        Eigen::AngleAxisd(rad_from_deg(link.theta_deg) + angles_rad[j], Eigen::Vector3d::UnitZ()));
    add_bar(j, {0, 0, link.d_mm});
    at.translate(Eigen::Vector3d(0, 0, link.d_mm));
    add_bar(j, {link.a_mm, 0, 0});
    at.translate(Eigen::Vector3d(link.a_mm, 0, 0));
    at.rotate(Eigen::AngleAxisd(rad_from_deg(link.alpha_deg), Eigen::Vector3d::UnitX()));
    at.rotate(Eigen::AngleAxisd(rad_from_deg(link.beta_deg), Eigen::Vector3d::UnitY()));
    if (masses)
      pieces.push_back({j, link.mass_kg, at * Eigen::Vector3d(link.mass_centre_mm.data())});
  }
  const std::size_t last = arm.links.size() - 1;
  const Eigen::Vector3d tool(arm.tool_x_mm, arm.tool_y_mm, arm.tool_z_mm);
  add_bar(last, tool);
  if (masses) pieces.push_back({last, arm.tool_mass_kg, at * tool});

  const Eigen::Vector3d down = Eigen::Vector3d(arm.gravity.data()).normalized();
  Eigen::VectorXd torques = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j) {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // weight x mm
    double weight = 0;
    for (const auto& piece : pieces) {
      if (piece.from < j) continue;
      moment += piece.weight * (piece.centre_mm - joints[j].origin_mm);
      weight += piece.weight;
    }
    const double about = kMPerMm * joints[j].direction.dot(moment.cross(down));
    torques[static_cast<Eigen::Index>(j)] =
        masses ? kGravity_m_per_s2 * about : (weight > 0 ? about / weight : 0);
  }
  return torques;
}

double play_side(double torque, bool masses) {
  return std::clamp(torque / (masses ? kFloating_newton_m : kFloating_m), -1.0, 1.0);
}

std::vector<Channel> drift_channels(const KinematicsDescription& arm) {
  std::vector<Channel> channels;
  for (const auto& link : arm.links) {
    const Channel& channel = link.errors.drift_channel;
    if (!channel.symbol.empty() && std::ranges::find(channels, channel) == channels.end())
      channels.push_back(channel);
  }
  return channels;
}

Eigen::VectorXd joint_turns_rad(const KinematicsDescription& arm,
                                std::span<const double> angles_rad,
                                std::span<const double> temperatures) {
  Eigen::VectorXd turns = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(arm.links.size()));
  const bool masses = has_masses(arm);
  Eigen::VectorXd torques;
  if (std::ranges::any_of(arm.links, reads_gravity)) torques = gravity_torques(arm, angles_rad);
  const auto channels = drift_channels(arm);
  for (std::size_t j = 0; j < arm.links.size(); ++j) {
    const auto& errors = arm.links[j].errors;
    double& turn = turns[static_cast<Eigen::Index>(j)];
    const double angle = angles_rad[j];
    turn = kRadPerArcsec *
           (errors.gear_cos1_arcsec * std::cos(angle) + errors.gear_sin1_arcsec * std::sin(angle) +
            errors.gear_cos2_arcsec * std::cos(2 * angle) +
            errors.gear_sin2_arcsec * std::sin(2 * angle));
    if (reads_gravity(arm.links[j])) {
      const double torque = torques[static_cast<Eigen::Index>(j)];
      turn += kRadPerUrad * (errors.sag_urad_per_m + errors.sag_urad_per_newton_m) * torque;
      turn += kRadPerArcsec * errors.play_arcsec / 2 * play_side(torque, masses);
    }
    if (errors.drift_channel.symbol.empty()) continue;
    const auto at = static_cast<std::size_t>(std::ranges::find(channels, errors.drift_channel) -
                                             channels.begin());
    const double kelvin =
        errors.drift_channel.unit == "K" ? temperatures[at] - 273.15 : temperatures[at];
    turn += kRadPerArcsec * errors.drift_arcsec_per_k * (kelvin - errors.drift_from_degC);
  }
  return turns;
}

}  // namespace driftwise::kinematics
