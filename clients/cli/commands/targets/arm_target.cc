#include "clients/cli/commands/targets/arm_target.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/compensation/geometry_law.h"
#include "server/core/reasons.h"
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

// Largest angle to be near to: a double still holds it to a part in 1e9 of a degree.
constexpr double kMostNear_deg = 1e6;
// Temperatures that a robot file may name as drift_from_degC.
constexpr double kLeast_degc = -100, kMost_degc = 200;

// Value of "rx_deg=180" or "rx=648000", in `unit`.
struct Assigned {
  std::string text, symbol, unit;  // unit: "" where none is given
  double value = 0;
};

Assigned assigned(const std::string& text) {
  const auto equals = text.find('=');
  const auto value =
      equals == std::string::npos ? std::nullopt : number_from(text.substr(equals + 1));
  if (!value)
    misused("found '" + text + "', expected something like x=800 (mm), rx_deg=180 or q1=0.2");
  const std::string name = text.substr(0, equals);
  if (const auto channel = parse_channel(name))
    return {text, channel->symbol, channel->unit, *value};
  return {text, name, "", *value};
}

double in_unit(const Assigned& one, const std::string& plain, const std::string& unit) {
  const auto conversion = unit_conversion(one.unit.empty() ? plain : one.unit, unit);
  if (!conversion) misused("'" + one.text + "': " + conversion.error().message);
  return (*conversion)(one.value);
}

using Words = std::map<std::string, Assigned>;  // by symbol

// Words of the command line, each symbol once and one of `known`. expected: what those are.
Words words_of(const std::vector<std::string>& texts, const std::vector<std::string>& known,
               const std::string& where, const std::string& expected) {
  Words words;
  for (const auto& text : texts) {
    auto one = assigned(text);
    if (std::ranges::find(known, one.symbol) == known.end())
      misused(where + "found '" + text + "', expected " + expected);
    const auto [at, added] = words.emplace(one.symbol, one);
    if (!added)
      misused(where + "found '" + at->second.text + "' and '" + text + "', expected " + one.symbol +
              " once");
  }
  return words;
}

Words pose_words(const ArmTargetArguments& a, const kinematics::SerialArm& arm) {
  std::vector<std::string> known = {"x", "y", "z"};
  std::string expected = "x, y, z (mm)";
  if (arm.joints() != 3) {
    known.insert(known.end(), {"rx", "ry", "rz"});
    expected += ", rx, ry, rz (arcsec; rx_deg=180)";
  }
  for (std::size_t i = arm.joints(); i < arm.inputs().size(); ++i) {
    const Channel& channel = arm.inputs()[i];
    known.push_back(channel.symbol);
    expected += ", " + channel.symbol + " (" + channel.unit + ")";
  }
  return words_of(a.pose, known, "", expected + ": a pose of this arm has nothing else");
}

// Temperature in the unit of the channel; a plain number is in that unit too.
double temperature_of(const Words& words, const Channel& channel) {
  const std::string examples = channel.symbol + "_degC=23.1 or " + channel.symbol + "_K=296.25";
  const auto found = words.find(channel.symbol);
  if (found == words.end())
    misused("the robot's joints drift with " + channel.name() + ": give it, such as " + examples);
  const double degc = in_unit(found->second, channel.unit, "degC");
  if (!(degc >= kLeast_degc && degc <= kMost_degc))
    misused("found '" + found->second.text + "', which is " + significant(degc, 6) +
            " degC, expected " + significant(kLeast_degc, 6) + " to " + significant(kMost_degc, 6) +
            " degC: the robot file reads " + channel.name() + "; give the unit, such as " +
            examples);
  return in_unit(found->second, channel.unit, channel.unit);
}

std::vector<double> near_of(const ArmTargetArguments& a, const kinematics::SerialArm& arm) {
  std::vector<std::string> known;
  for (std::size_t j = 0; j < arm.joints(); ++j) known.push_back(arm.inputs()[j].symbol);
  const auto words = words_of(
      a.near, known, "--near: ",
      "joints " + known.front() + " to " + known.back() + ", such as " + known.front() + "_deg=20");
  std::vector<double> near(arm.joints(), 0);
  for (std::size_t j = 0; j < arm.joints(); ++j) {
    const auto found = words.find(known[j]);
    if (found == words.end()) continue;
    near[j] = in_unit(found->second, arm.inputs()[j].unit, arm.inputs()[j].unit);
    if (!(std::abs(kinematics::deg_from_rad(near[j] * arm.rad_per_unit(j))) <= kMostNear_deg))
      misused("--near: found '" + found->second.text +
              "', expected an angle from -1000000 to 1000000 deg");
  }
  return near;
}

struct Question {
  kinematics::WantedPose wanted;
  std::vector<double> near, temperatures;
};

Question question_of(const ArmTargetArguments& a, const kinematics::SerialArm& arm) {
  Question question;
  const auto words = pose_words(a, arm);
  const auto coordinate = [&](const char* symbol, const char* plain, const char* unit) {
    const auto found = words.find(symbol);
    if (found == words.end())
      misused(std::string("the target has no ") + symbol +
              ": six joints need x, y, z (mm) and rx, "
              "ry, rz (arcsec; rx_deg=180), three need x, y, z");
    return in_unit(found->second, plain, unit);
  };
  const auto length = [&](const char* symbol) { return coordinate(symbol, "mm", "mm"); };
  const auto turn = [&](const char* symbol) { return coordinate(symbol, "arcsec", "deg"); };
  const double x = length("x"), y = length("y"), z = length("z");
  question.wanted.point_mm = {x, y, z};
  if (arm.joints() != 3) {
    const double rx = turn("rx"), ry = turn("ry"), rz = turn("rz");
    Eigen::Matrix<double, kinematics::kFrameParameters, 1> frame;
    frame << 0, 0, 0, rx, ry, rz;
    question.wanted.axes = kinematics::Frame(frame).rotation();
  }
  question.near = near_of(a, arm);
  for (std::size_t i = arm.joints(); i < arm.inputs().size(); ++i)
    question.temperatures.push_back(temperature_of(words, arm.inputs()[i]));
  return question;
}

// The rule by which the daemon refuses a pose, of geometry_law.h.
void refuse_missed(const kinematics::JointSolution& solution) {
  if (solution.miss_nm <= compensation::kMostMiss_nm) return;
  throw failure_of({ErrorCode::out_of_range, reasons::kNoPose,
                    "the forward model misses the pose by " + significant(solution.miss_nm, 3) +
                        " nm at the joint angles found, more than " +
                        significant(compensation::kMostMiss_nm, 3) +
                        " nm: not given; ask for a pose farther from the edge of the reach, or "
                        "for smaller angles to be near to"});
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
  refuse_missed(solution);
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
