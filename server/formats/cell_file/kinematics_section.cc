#include "server/formats/cell_file/kinematics_section.h"

#include <cmath>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_text.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::formats {
namespace {

constexpr Range kLength_mm{.min = -1e5, .max = 1e5};
constexpr Range kPositive_mm{.min = 0, .max = 1e5, .above_min = true};
constexpr Range kAngle_deg{.min = -360, .max = 360};
constexpr Range kLimit_deg{.min = -36000, .max = 36000};  // a hundred turns
constexpr Range kScale_ppm{.min = -1e5, .max = 1e5};
constexpr Range kMass_kg{.min = 0, .max = 1e4};
constexpr Range kSag_urad{.min = -1e5, .max = 1e5};
constexpr Range kJoint_arcsec{.min = -36000, .max = 36000};
constexpr Range kTemperature_degC{.min = -100, .max = 200};

void read_motor(TomlReader& reader, Channel& out) {
  reader.channel("motor", out, Need::required);
  if (!out.symbol.empty() && !is_motor_symbol(out.symbol))
    reader.refuse("motor", reasons::kBadChannel,
                  "found " + shown(out.name()) + ", expected a motor coordinate such as q1_mm");
}

void read_branch(TomlReader&& reader, DeltaBranch& out) {
  read_motor(reader, out.motor);
  reader.number("azimuth_deg", out.azimuth_deg, kAngle_deg, Need::required);
  reader.number("radius_mm", out.radius_mm, kPositive_mm, Need::required);
  reader.number("length_mm", out.length_mm, kPositive_mm, Need::required);
  reader.number("offset_mm", out.offset_mm, kLength_mm);
  reader.number("tilt_radial_deg", out.tilt_radial_deg, {.min = -80, .max = 80});
  reader.number("tilt_tangential_deg", out.tilt_tangential_deg, {.min = -45, .max = 45});
  reader.number("scale_ppm", out.scale_ppm, kScale_ppm);
  reader.finish();
}

void read_link(TomlReader&& reader, ArmLink& out) {
  read_motor(reader, out.motor);
  reader.number("theta_deg", out.theta_deg, kAngle_deg);
  reader.number("d_mm", out.d_mm, kLength_mm, Need::required);
  reader.number("a_mm", out.a_mm, kLength_mm, Need::required);
  reader.number("alpha_deg", out.alpha_deg, kAngle_deg, Need::required);
  reader.number("beta_deg", out.beta_deg, kAngle_deg);
  reader.number("mass_kg", out.mass_kg, kMass_kg);
  reader.vector3("mass_centre_mm", out.mass_centre_mm, kLength_mm.max);
  JointErrors& errors = out.errors;
  reader.number("sag_urad_per_m", errors.sag_urad_per_m, kSag_urad);
  reader.number("sag_urad_per_newton_m", errors.sag_urad_per_newton_m, kSag_urad);
  reader.number("play_arcsec", errors.play_arcsec, kJoint_arcsec);
  reader.number("gear_cos1_arcsec", errors.gear_cos1_arcsec, kJoint_arcsec);
  reader.number("gear_sin1_arcsec", errors.gear_sin1_arcsec, kJoint_arcsec);
  reader.number("gear_cos2_arcsec", errors.gear_cos2_arcsec, kJoint_arcsec);
  reader.number("gear_sin2_arcsec", errors.gear_sin2_arcsec, kJoint_arcsec);
  reader.channel("drift_channel", errors.drift_channel, Need::optional);
  reader.number("drift_arcsec_per_k", errors.drift_arcsec_per_k, kJoint_arcsec);
  reader.number("drift_from_degC", errors.drift_from_degC, kTemperature_degC);
  reader.number("min_deg", out.min_deg, kLimit_deg);
  reader.number("max_deg", out.max_deg, kLimit_deg);
  reader.finish();
}

void read_linear_axis(TomlReader&& reader, LinearAxis& out) {
  read_motor(reader, out.motor);
  reader.channel("pose", out.pose, Need::required);
  reader.number("offset_mm", out.offset_mm, kLength_mm);
  reader.number("scale_ppm", out.scale_ppm, kScale_ppm);
  if (!out.pose.symbol.empty() && !is_pose_symbol(out.pose.symbol))
    reader.refuse("pose", reasons::kBadChannel,
                  "found " + shown(out.pose.name()) + ", expected a pose coordinate such as x_mm");
  reader.finish();
}

void read_frame(TomlReader&& reader, FrameDescription& out) {
  reader.number("x_mm", out.x_mm, kLength_mm);
  reader.number("y_mm", out.y_mm, kLength_mm);
  reader.number("z_mm", out.z_mm, kLength_mm);
  reader.number("rx_deg", out.rx_deg, kAngle_deg);
  reader.number("ry_deg", out.ry_deg, kAngle_deg);
  reader.number("rz_deg", out.rz_deg, kAngle_deg);
  reader.finish();
}

void append_line(std::string& text, const char* key, double value) {
  text += std::string(key) + " = ";
  const std::string number = number_text(value);
  text += number + '\n';
}

// Only what differs from the default: a drawing rarely says more.
void append_unless_zero(std::string& text, const char* key, double value) {
  if (value != 0) append_line(text, key, value);
}

void append_vector(std::string& text, const char* key, const std::array<double, 3>& values) {
  text += std::string(key) + " = [" + number_text(values[0]) + ", " + number_text(values[1]) +
          ", " + number_text(values[2]) + "]\n";
}

void append_errors(std::string& text, const JointErrors& errors) {
  append_unless_zero(text, "sag_urad_per_m", errors.sag_urad_per_m);
  append_unless_zero(text, "sag_urad_per_newton_m", errors.sag_urad_per_newton_m);
  append_unless_zero(text, "play_arcsec", errors.play_arcsec);
  append_unless_zero(text, "gear_cos1_arcsec", errors.gear_cos1_arcsec);
  append_unless_zero(text, "gear_sin1_arcsec", errors.gear_sin1_arcsec);
  append_unless_zero(text, "gear_cos2_arcsec", errors.gear_cos2_arcsec);
  append_unless_zero(text, "gear_sin2_arcsec", errors.gear_sin2_arcsec);
  if (errors.drift_channel.symbol.empty()) return;
  text += "drift_channel = \"" + errors.drift_channel.name() + "\"\n";
  append_line(text, "drift_arcsec_per_k", errors.drift_arcsec_per_k);
  append_line(text, "drift_from_degC", errors.drift_from_degC);
}

}  // namespace

void read_kinematics(const toml::table& table, KinematicsDescription& out, TomlProblem& problem) {
  TomlReader reader(table, "kinematics", problem);
  reader.choice("kind", out.kind, {"delta-vertical", "serial-arm", "linear-axis"}, Need::required);
  if (problem.any()) return;  // without a kind the rest cannot be judged
  const auto place = [](const char* what, std::size_t count) {
    return std::string("kinematics, ") + what + " " + std::to_string(count);
  };
  if (out.kind == "delta-vertical") {
    std::string carriages = "above";
    reader.choice("carriages", carriages, {"above", "below"}, Need::optional);
    out.carriages_above = carriages == "above";
    for (const auto* one : reader.tables("branch")) {
      auto& branch = out.branches.emplace_back();
      read_branch(TomlReader(*one, place("branch", out.branches.size()), problem), branch);
    }
  } else if (out.kind == "serial-arm") {
    for (const auto* one : reader.tables("link")) {
      auto& link = out.links.emplace_back();
      read_link(TomlReader(*one, place("link", out.links.size()), problem), link);
    }
    reader.number("tool_x_mm", out.tool_x_mm, kLength_mm);
    reader.number("tool_y_mm", out.tool_y_mm, kLength_mm);
    reader.number("tool_z_mm", out.tool_z_mm, kLength_mm);
    reader.number("tool_mass_kg", out.tool_mass_kg, kMass_kg);
    reader.vector3("gravity", out.gravity, 1e3);
  } else {
    for (const auto* one : reader.tables("axis")) {
      auto& axis = out.axes.emplace_back();
      read_linear_axis(TomlReader(*one, place("axis", out.axes.size()), problem), axis);
    }
  }
  if (out.kind != "linear-axis")
    if (const auto* frame = reader.table("frame"))
      read_frame(TomlReader(*frame, "kinematics, frame", problem), out.frame);
  reader.texts("hold", out.hold);
  reader.finish();
  if (problem.any()) return;
  if (const auto made = kinematics::make_mechanism(out); !made)
    problem.add(made.error().code, made.error().reason, table.source(), made.error().message);
}

Result<KinematicsDescription> parse_robot_file(std::string_view text,
                                               const std::string& file_name) {
  TomlProblem problem{.file_name = file_name, .first = {}};
  KinematicsDescription description;
  try {
    const toml::table root = parse_toml(text, file_name);
    TomlReader top(root, "", problem);
    const auto* section = top.table("kinematics");
    if (section != nullptr)
      read_kinematics(*section, description, problem);
    else
      top.refuse("kinematics", reasons::kNoKinematics,
                 "found no [kinematics] section, expected one with kind and lengths: see "
                 "docs/kinematics.md");
    if (!root.contains("cell")) top.finish();
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, file_name));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  return description;
}

std::string write_robot_file(const KinematicsDescription& description) {
  std::string text = "[kinematics]\nkind = \"" + description.kind + "\"\n";
  if (description.kind == "delta-vertical")
    text +=
        std::string("carriages = \"") + (description.carriages_above ? "above" : "below") + "\"\n";
  append_unless_zero(text, "tool_x_mm", description.tool_x_mm);
  append_unless_zero(text, "tool_y_mm", description.tool_y_mm);
  append_unless_zero(text, "tool_z_mm", description.tool_z_mm);
  append_unless_zero(text, "tool_mass_kg", description.tool_mass_kg);
  if (description.gravity != KinematicsDescription{}.gravity)
    append_vector(text, "gravity", description.gravity);
  if (!description.hold.empty()) {
    text += "hold = [";
    for (std::size_t i = 0; i < description.hold.size(); ++i)
      text += (i == 0 ? "\"" : ", \"") + description.hold[i] + "\"";
    text += "]\n";
  }
  const FrameDescription& frame = description.frame;
  std::string placed;
  append_unless_zero(placed, "x_mm", frame.x_mm);
  append_unless_zero(placed, "y_mm", frame.y_mm);
  append_unless_zero(placed, "z_mm", frame.z_mm);
  append_unless_zero(placed, "rx_deg", frame.rx_deg);
  append_unless_zero(placed, "ry_deg", frame.ry_deg);
  append_unless_zero(placed, "rz_deg", frame.rz_deg);
  if (!placed.empty()) text += "\n[kinematics.frame]\n" + placed;
  for (const auto& branch : description.branches) {
    text += "\n[[kinematics.branch]]\nmotor = \"" + branch.motor.name() + "\"\n";
    append_line(text, "azimuth_deg", branch.azimuth_deg);
    append_line(text, "radius_mm", branch.radius_mm);
    append_line(text, "length_mm", branch.length_mm);
    append_unless_zero(text, "offset_mm", branch.offset_mm);
    append_unless_zero(text, "tilt_radial_deg", branch.tilt_radial_deg);
    append_unless_zero(text, "tilt_tangential_deg", branch.tilt_tangential_deg);
    append_unless_zero(text, "scale_ppm", branch.scale_ppm);
  }
  for (const auto& link : description.links) {
    text += "\n[[kinematics.link]]\nmotor = \"" + link.motor.name() + "\"\n";
    append_unless_zero(text, "theta_deg", link.theta_deg);
    append_line(text, "d_mm", link.d_mm);
    append_line(text, "a_mm", link.a_mm);
    append_line(text, "alpha_deg", link.alpha_deg);
    append_unless_zero(text, "beta_deg", link.beta_deg);
    append_unless_zero(text, "mass_kg", link.mass_kg);
    if (link.mass_centre_mm != ArmLink{}.mass_centre_mm)
      append_vector(text, "mass_centre_mm", link.mass_centre_mm);
    append_errors(text, link.errors);
    if (std::isfinite(link.min_deg)) append_line(text, "min_deg", link.min_deg);
    if (std::isfinite(link.max_deg)) append_line(text, "max_deg", link.max_deg);
  }
  for (const auto& axis : description.axes) {
    text += "\n[[kinematics.axis]]\nmotor = \"" + axis.motor.name() + "\"\npose = \"" +
            axis.pose.name() + "\"\n";
    append_unless_zero(text, "offset_mm", axis.offset_mm);
    append_unless_zero(text, "scale_ppm", axis.scale_ppm);
  }
  return text;
}

}  // namespace driftwise::formats
