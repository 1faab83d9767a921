#include "server/formats/diagnosis/robot_names.h"

#include <algorithm>
#include <cctype>
#include <functional>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"

namespace driftwise::formats {
namespace {

// x of x_std and of x_mm.
std::string_view coordinate_of(std::string_view local) { return local.substr(0, local.find('_')); }

bool is_coordinate(std::string_view symbol) {
  const auto stem = coordinate_of(without_robot(symbol));
  return is_motor_symbol(stem) || is_pose_symbol(stem);
}

bool is_of_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Every name in the text replaced by what `to` makes of it. The dot at the end of a sentence is
// none of a name.
std::string each_name(std::string_view text,
                      const std::function<std::string(std::string_view)>& to) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    if (!is_of_name(text[at])) {
      out += text[at++];
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && is_of_name(text[end])) ++end;
    std::size_t name_end = end;
    while (name_end > at && text[name_end - 1] == '.') --name_end;
    out += to(text.substr(at, name_end - at));
    out += text.substr(name_end, end - name_end);
    at = end;
  }
  return out;
}

using Rename = std::function<std::string(std::string_view)>;

void rename(effects::Term& term, const Rename& to) {
  for (auto& factor : term.factors) {
    if (auto* power = std::get_if<effects::Power>(&factor))
      power->symbol = to(power->symbol);
    else
      for (auto& symbol : std::get<effects::Call>(factor).symbols) symbol = to(symbol);
  }
}

void rename(diagnosis::Finding& finding, const Rename& to) {
  for (auto& parameter : finding.parameters)  // "nm_per_k_q1", one for each output
    for (const auto& output : finding.outputs)
      if (parameter.name.ends_with("_" + output.output))
        parameter.name.replace(parameter.name.size() - output.output.size(), std::string::npos,
                               to(output.output));
  finding.subject = to(finding.subject);
  for (auto& term : finding.terms) rename(term, to);
  for (auto& other : finding.indistinguishable_from) other = to(other);
  for (auto& output : finding.outputs) output.output = to(output.output);
  finding.sentence = to(finding.sentence);
}

diagnosis::Diagnosis renamed(diagnosis::Diagnosis found, const Rename& to) {
  found.baseline_formula = to(found.baseline_formula);
  found.extended_formula = to(found.extended_formula);
  for (auto& output : found.outputs) {
    output.output = to(output.output);
    for (auto& share : output.explained_by) share.variable = to(share.variable);
  }
  for (auto& finding : found.findings) rename(finding, to);
  for (auto& one : found.not_testable) one = {to(one.cause), to(one.why)};
  for (auto& one : found.left_over) one.goes_with = to(one.goes_with);
  if (auto& experiment = found.separating_experiment) {
    experiment->why = to(experiment->why);
    experiment->trajectory_csv = to(experiment->trajectory_csv);
  }
  for (auto& warning : found.warnings) warning = to(warning);
  return found;
}

std::string listed(const std::set<std::string>& robots) {
  std::string text;
  for (const auto& robot : robots) text += (text.empty() ? "" : ", ") + shown(robot);
  return text;
}

// Ids on the left of the formula: of "ma.q1 + ma.q2 ~ ..." {"ma"}.
std::set<std::string> robots_of_outputs(std::string_view formula) {
  std::set<std::string> robots;
  const auto left = formula.substr(0, std::min(formula.find('~'), formula.size()));
  each_name(left, [&robots](std::string_view name) {
    if (!robot_of(name).empty()) robots.emplace(robot_of(name));
    return std::string(name);
  });
  return robots;
}

}  // namespace

RobotNames::RobotNames(const Dataset& dataset, std::string robot) : robot_(std::move(robot)) {
  if (robot_.empty()) return;
  for (const auto& column : dataset.columns) {
    if (robot_of(column.channel.symbol) != robot_ || !is_coordinate(column.channel.symbol))
      continue;
    const std::string local(without_robot(column.channel.symbol));
    own_.insert(local);
    own_.insert(Channel{local, column.channel.unit}.name());
    if (is_motor_symbol(local)) own_.insert("q");
  }
}

std::string RobotNames::bare(std::string_view text) const {
  return each_name(text, [this](std::string_view name) {
    const bool is_own = !robot_.empty() && robot_of(name) == robot_;
    return std::string(is_own ? without_robot(name) : name);
  });
}

std::string RobotNames::with_id(std::string_view text) const {
  return each_name(text, [this](std::string_view name) {
    return own_.contains(name) ? robot_ + "." + std::string(name) : std::string(name);
  });
}

Dataset RobotNames::bare(Dataset dataset) const {
  for (auto& column : dataset.columns) column.channel.symbol = bare(column.channel.symbol);
  return dataset;
}

diagnosis::Diagnosis RobotNames::bare(diagnosis::Diagnosis found) const {
  if (robot_.empty()) return found;
  return renamed(std::move(found), [this](std::string_view text) { return bare(text); });
}

diagnosis::Diagnosis RobotNames::with_id(diagnosis::Diagnosis found) const {
  if (robot_.empty()) return found;
  return renamed(std::move(found), [this](std::string_view text) { return with_id(text); });
}

correction::DataAmendment RobotNames::with_id(correction::DataAmendment amendment) const {
  for (auto& shift : amendment.shifts) {
    shift.axis = with_id(shift.axis);
    for (auto& term : shift.terms)
      rename(term, [this](std::string_view symbol) { return with_id(symbol); });
  }
  for (auto& shift : amendment.angles) {
    shift.axis = with_id(shift.axis);
    for (auto& term : shift.terms)
      rename(term, [this](std::string_view symbol) { return with_id(symbol); });
  }
  return amendment;
}

Error RobotNames::with_id(Error error) const {
  error.message = with_id(error.message);
  return error;
}

std::set<std::string> robots_in(const Dataset& dataset) {
  std::set<std::string> robots;
  for (const auto& column : dataset.columns)
    if (!robot_of(column.channel.symbol).empty() && is_coordinate(column.channel.symbol))
      robots.emplace(robot_of(column.channel.symbol));
  return robots;
}

Result<std::string> robot_asked_for(const Dataset& dataset, std::string_view formula,
                                    const std::string& asked) {
  const auto robots = robots_in(dataset);
  const auto named = robots_of_outputs(formula);
  const auto other = [](const std::string& message) {
    return fail(ErrorCode::invalid_argument, reasons::kOtherRobot, message);
  };
  if (named.size() > 1)
    return other("the baseline has outputs of the robots " + listed(named) +
                 ": a diagnosis is of one robot, make one for each");
  const std::string robot = !asked.empty() ? asked : named.empty() ? "" : *named.begin();
  if (!named.empty() && robot != *named.begin())
    return other("robot " + shown(asked) + " is asked for, and the baseline is of robot " +
                 listed(named) + ": name the same one");
  if (robot.empty()) {
    if (robots.size() <= 1) return robots.empty() ? std::string() : *robots.begin();
    return fail(ErrorCode::invalid_argument, reasons::kAmbiguousCoordinate,
                "the data are of several robots, " + listed(robots) +
                    ": name the one to look at (--robot " + *robots.begin() +
                    "), or write its id before the baseline's outputs (" + *robots.begin() +
                    ".q ~ ...)");
  }
  if (robots.contains(robot)) return robot;
  return other(robots.empty()
                   ? "robot " + shown(robot) +
                         " is asked for, and the channels of these data name no robot: they are of "
                         "a cell with one robot, leave its name out"
                   : "the data have no channel of robot " + shown(robot) + "; their robots are " +
                         listed(robots));
}

std::string robot_of_formula(std::string_view formula) {
  const auto robots = robots_of_outputs(formula);
  return robots.empty() ? std::string() : *robots.begin();
}

}  // namespace driftwise::formats
