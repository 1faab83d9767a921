#include "clients/cli/commands/targets/arm_target.h"

#include <map>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/core/unit_conversion.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/kinematics/angles.h"
#include "server/kinematics/arm_inverse.h"
#include "server/kinematics/frame.h"

namespace driftwise::cli {
namespace {

[[noreturn]] void misused(const std::string& message) {
  throw Failure{ExitCode::usage, "usage", "USAGE", message};
}

// "rx_deg=180" or "rx=648000": the value in `unit`; without a unit it is in `plain`.
struct Assigned {
  std::string symbol, unit;  // unit: "" where none is given
  double value = 0;
};

Assigned assigned(const std::string& text) {
  const auto equals = text.find('=');
  const auto value =
      equals == std::string::npos ? std::nullopt : number_from(text.substr(equals + 1));
  if (!value)
    misused("found '" + text + "', expected something like x=800 (mm), rx_deg=180 or q1=0.2");
  const std::string name = text.substr(0, equals);
  if (const auto channel = parse_channel(name)) return {channel->symbol, channel->unit, *value};
  return {name, "", *value};
}

double in_unit(const Assigned& one, const std::string& plain, const std::string& unit) {
  const auto conversion = unit_conversion(one.unit.empty() ? plain : one.unit, unit);
  if (!conversion) misused(one.symbol + ": " + conversion.error().message);
  return (*conversion)(one.value);
}

struct Question {
  kinematics::WantedPose wanted;
  std::vector<double> near, temperatures;
};

Question question_of(const ArmTargetArguments& a, const kinematics::SerialArm& arm) {
  Question question;
  std::map<std::string, double> pose;  // mm, rad
  std::map<std::string, double> conditions;
  for (const auto& text : a.pose) {
    const auto one = assigned(text);
    if (is_pose_symbol(one.symbol))
      pose[one.symbol] =
          one.symbol.size() == 1 ? in_unit(one, "mm", "mm") : in_unit(one, "arcsec", "rad");
    else
      conditions[one.symbol] = in_unit(one, "degC", "degC");
  }
  const auto coordinate = [&](const char* symbol) {
    const auto found = pose.find(symbol);
    if (found == pose.end())
      misused(std::string("the target has no ") + symbol +
              ": six joints need x, y, z (mm) and rx, "
              "ry, rz (arcsec; rx_deg=180), three need x, y, z");
    return found->second;
  };
  const double x = coordinate("x"), y = coordinate("y"), z = coordinate("z");
  question.wanted.point_mm = {x, y, z};
  if (arm.joints() != 3) {
    const double rx = coordinate("rx"), ry = coordinate("ry"), rz = coordinate("rz");
    Eigen::Matrix<double, kinematics::kFrameParameters, 1> frame;
    frame << 0, 0, 0, kinematics::deg_from_rad(rx), kinematics::deg_from_rad(ry),
        kinematics::deg_from_rad(rz);
    question.wanted.axes = kinematics::Frame(frame).rotation();
  }
  question.near.assign(arm.joints(), 0);
  for (const auto& text : a.near) {
    const auto one = assigned(text);
    bool known = false;
    for (std::size_t j = 0; j < arm.joints(); ++j) {
      const Channel& motor = arm.inputs()[j];
      if (motor.symbol != one.symbol) continue;
      question.near[j] = in_unit(one, motor.unit, motor.unit);
      known = true;
    }
    if (!known) misused("--near: the robot has no joint " + one.symbol);
  }
  for (std::size_t i = arm.joints(); i < arm.inputs().size(); ++i) {
    const Channel& channel = arm.inputs()[i];
    const auto found = conditions.find(channel.symbol);
    if (found == conditions.end())
      misused("the robot's joints drift with " + channel.name() + ": give it, " + channel.symbol +
              "=23.1");
    const auto conversion = unit_conversion("degC", channel.unit);
    question.temperatures.push_back((*conversion)(found->second));
  }
  return question;
}

}  // namespace

ExitCode arm_target(const Session& session, const ArmTargetArguments& a) {
  const auto description =
      value_or_throw(formats::parse_robot_file(read_input_file(a.kinematics), a.kinematics));
  if (description.kind != "serial-arm")
    misused("--kinematics goes with a serial-arm, " + a.kinematics + " describes a " +
            description.kind);
  const auto arm = value_or_throw(kinematics::SerialArm::create(description));
  const auto question = question_of(a, arm);
  const auto solution = value_or_throw(
      kinematics::nearest_joints(arm, kinematics::nominal_values(arm.parameters()), question.wanted,
                                 question.near, question.temperatures));
  if (solution.beyond != 0) throw failure_of(kinematics::beyond_limits(arm, solution));
  if (session.console.json) {
    nlohmann::ordered_json json;
    for (std::size_t j = 0; j < arm.joints(); ++j)
      json["joints"][arm.inputs()[j].name()] = solution.joints[j];
    json["miss_nm"] = solution.miss_nm;
    if (question.wanted.axes) json["miss_arcsec"] = solution.miss_arcsec;
    json["solutions"] = solution.solutions;
    json["least_motion"] = solution.least_motion;
    session.console.print_json(json);
    return ExitCode::done;
  }
  Table table({{"joint"}, {"angle", Align::right}, {"deg", Align::right}});
  for (std::size_t j = 0; j < arm.joints(); ++j) {
    const Channel& motor = arm.inputs()[j];
    table.add({motor.name(), fixed(solution.joints[j], 9),
               fixed(kinematics::deg_from_rad(solution.joints[j] * arm.rad_per_unit(j)), 6)});
  }
  table.print(session.console.out, session.console.paint_out());
  session.console.out << "nearest of " << solution.solutions
                      << (solution.solutions == 1 ? " solution" : " solutions")
                      << "; the forward model is " << significant(solution.miss_nm, 2)
                      << " nm off at these angles\n";
  return ExitCode::done;
}

}  // namespace driftwise::cli
