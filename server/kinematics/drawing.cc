#include "server/kinematics/drawing.h"

#include <string_view>

namespace driftwise::kinematics {
namespace {

double* field(FrameDescription& frame, std::string_view key) {
  if (key == "x_mm") return &frame.x_mm;
  if (key == "y_mm") return &frame.y_mm;
  if (key == "z_mm") return &frame.z_mm;
  if (key == "rx_deg") return &frame.rx_deg;
  if (key == "ry_deg") return &frame.ry_deg;
  if (key == "rz_deg") return &frame.rz_deg;
  return nullptr;
}

double* field(DeltaBranch& branch, std::string_view key) {
  if (key == "radius_mm") return &branch.radius_mm;
  if (key == "azimuth_deg") return &branch.azimuth_deg;
  if (key == "length_mm") return &branch.length_mm;
  if (key == "offset_mm") return &branch.offset_mm;
  if (key == "tilt_radial_deg") return &branch.tilt_radial_deg;
  if (key == "tilt_tangential_deg") return &branch.tilt_tangential_deg;
  if (key == "scale_ppm") return &branch.scale_ppm;
  return nullptr;
}

double* field(ArmLink& link, std::string_view key) {
  if (key == "theta_deg") return &link.theta_deg;
  if (key == "d_mm") return &link.d_mm;
  if (key == "a_mm") return &link.a_mm;
  if (key == "alpha_deg") return &link.alpha_deg;
  if (key == "beta_deg") return &link.beta_deg;
  return nullptr;
}

double* field(LinearAxis& axis, std::string_view key) {
  if (key == "offset_mm") return &axis.offset_mm;
  if (key == "scale_ppm") return &axis.scale_ppm;
  return nullptr;
}

// "link2.a_mm", "branch1.radius_mm", "frame.x_mm", "tool.z_mm", "axis.scale_ppm"
double* field(KinematicsDescription& drawing, const std::string& name) {
  const auto dot = name.find('.');
  const std::string_view part(name.data(), dot);
  const auto key = std::string_view(name).substr(dot + 1);
  const auto nth = [&](auto& all, std::size_t prefix) -> double* {
    const auto at = static_cast<std::size_t>(std::stoi(name.substr(prefix))) - 1;
    return at < all.size() ? field(all[at], key) : nullptr;
  };
  if (part == "frame") return field(drawing.frame, key);
  if (part == "axis" && !drawing.axes.empty()) return field(drawing.axes.front(), key);
  if (part == "tool") {
    if (key == "x_mm") return &drawing.tool_x_mm;
    if (key == "y_mm") return &drawing.tool_y_mm;
    return &drawing.tool_z_mm;
  }
  if (part.starts_with("link")) return nth(drawing.links, 4);
  if (part.starts_with("branch")) return nth(drawing.branches, 6);
  return nullptr;
}

}  // namespace

KinematicsDescription with_values(const Mechanism& mechanism, const Eigen::VectorXd& values) {
  KinematicsDescription drawing = mechanism.description();
  for (std::size_t k = 0; k < mechanism.parameters().size(); ++k)
    if (double* at = field(drawing, mechanism.parameters()[k].name))
      *at = values[static_cast<Eigen::Index>(k)];
  return drawing;
}

}  // namespace driftwise::kinematics
