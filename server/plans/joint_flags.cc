// Names of robots and coordinates, flags and refusals of joint targets as texts.

#include <algorithm>
#include <bit>
#include <concepts>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/effects/term_order.h"
#include "server/plans/joint_target.h"

namespace driftwise::plans {
namespace {

using compensation::Refusal;
using compensation::Snapshot;
using compensation::Variable;

void append_channel(std::string& out, std::string_view robot, std::string_view channel) {
  if (!robot.empty()) (out += robot) += '.';
  out += channel;
}

void append_inputs(std::string& out, std::string_view robot, const Snapshot& model,
                   std::uint64_t bits, char between) {
  bool first = true;
  for (std::size_t i = 0; i < model.inputs.size(); ++i) {
    if ((bits >> i & 1) == 0) continue;
    if (!std::exchange(first, false)) out += between;
    const auto& input = model.inputs[i];
    append_channel(out, input.variable ? robot : "", input.channel.symbol);
    (out += '_') += input.channel.unit;
  }
}
std::string inputs_text(std::string_view robot, const Snapshot& model, std::uint64_t bits) {
  std::string out;
  append_inputs(out, robot, model, bits, ' ');
  return out;
}

void append_coordinates(std::string& out, std::string_view robot, std::uint32_t bits,
                        char between) {
  bool first = true;
  for (std::size_t v = 0; v < compensation::kVariables; ++v) {
    if ((bits >> v & 1) == 0) continue;
    if (!std::exchange(first, false)) out += between;
    append_channel(out, robot, compensation::name_of(static_cast<Variable>(v)));
  }
}
// With the id of the robot that the request named; those that it stated for any robot have none.
void append_ignored(std::string& out, const JointSnapshot& snapshot, const JointTarget& target,
                    char between) {
  bool first = true;
  for (std::size_t r = 0; r < target.ignored.size(); ++r) {
    if (target.ignored[r] == 0) continue;
    if (!std::exchange(first, false)) out += between;
    const bool named = r < snapshot.robots.size();
    append_coordinates(out, named ? std::string_view(snapshot.robots[r].id) : "", target.ignored[r],
                       between);
  }
}
std::string coordinates_text(std::string_view robot, std::uint32_t bits) {
  std::string out;
  append_coordinates(out, robot, bits, ' ');
  return out;
}

void append_axes(std::string& out, const JointSnapshot::Robot& robot, std::uint32_t bits) {
  bool first = true;
  for (std::size_t i = 0; i < robot.fine.outputs.size(); ++i) {
    if ((bits >> i & 1) == 0) continue;
    if (!std::exchange(first, false)) out += '+';
    append_channel(out, robot.id, robot.fine.outputs[i].channel.symbol);
  }
}
std::string axes_text(const JointSnapshot::Robot& robot, std::uint32_t bits) {
  std::string out;
  append_axes(out, robot, bits);
  return out;
}

// Every model that a robot's answer holds, with its flags.
template <class Visit>
void visit_answering(const JointSnapshot::Robot& robot, const JointTarget::Robot& answer,
                     const Visit& visit) {
  if (answer.by != AnsweredBy::coarse) visit(robot.fine, answer.fine);
  if (answer.by == AnsweredBy::coarse || answer.by == AnsweredBy::blend)
    visit(*robot.coarse, answer.coarse);
}

// Flags one after another, parted by commas, each once. Nothing here but the text itself grows.
class FlagText {
 public:
  FlagText(std::string& out, char between) : out_(out), start_(out.size()), between_(between) {}

  // append_whom: what the flag is about, set in brackets; nothing: no brackets.
  template <std::invocable AppendWhom>
  void add(std::string_view name, const AppendWhom& append_whom) {
    const std::size_t begin = out_.size();
    if (begin > start_) out_ += ',';
    const std::size_t flag = out_.size();
    (out_ += name) += '(';
    const std::size_t whom = out_.size();
    append_whom();
    if (out_.size() == whom)
      out_.pop_back();
    else
      out_ += ')';
    if (is_there(std::string_view(out_).substr(start_, begin - start_),
                 std::string_view(out_).substr(flag)))
      out_.resize(begin);
  }
  void add(std::string_view name, std::string_view whom) {
    add(name, [&] { out_ += whom; });
  }
  void add_model(std::string_view robot, const Snapshot& model, const ModelFlags& bits) {
    const auto add_inputs = [&](std::uint32_t flag, std::string_view name, std::uint64_t which) {
      if ((bits.flags & flag) == 0) return;
      if (which == 0) return add(name, robot);
      add(name, [&] { append_inputs(out_, robot, model, which, between_); });
    };
    add_inputs(compensation::kOutsideDomain, reasons::kOutsideDomain.view(), bits.outside);
    add_inputs(compensation::kStaleTemperature, "STALE_TEMPERATURE", bits.stale);
    add_inputs(compensation::kMissingTemperature, "MISSING_TEMPERATURE", bits.missing);
    add_inputs(compensation::kExpiredConditions, "EXPIRED_CONDITIONS", 0);
    add_inputs(compensation::kUnanchoredDatum, "UNANCHORED_DATUM", 0);
    add_inputs(compensation::kConfigurationChanged, reasons::kConfigurationChanged.view(), 0);
    add_inputs(compensation::kZeroOutsideDomain, "ZERO_OUTSIDE_DOMAIN", model.zero_outside);
    add_inputs(compensation::kDoubtfulModel, "DOUBTFUL_MODEL", 0);
  }

 private:
  static bool is_there(std::string_view flags, std::string_view flag) {
    while (!flags.empty()) {
      const auto one = flags.substr(0, flags.find(','));
      if (one == flag) return true;
      flags.remove_prefix(std::min(flags.size(), one.size() + 1));
    }
    return false;
  }

  std::string& out_;
  std::size_t start_;
  char between_;
};

Error refused_request(const JointSnapshot& snapshot, const JointTarget& target) {
  const std::string& robot = snapshot.robots[target.refused_robot].id;
  const std::string names = coordinates_text(robot, target.refused);
  if (target.refusal == Refusal::not_finite)
    return {ErrorCode::invalid_argument, reasons::kNotFinite,
            "found no finite number for " + names + ": state it in the unit of its name"};
  if (target.ambiguous)
    return {ErrorCode::invalid_argument, reasons::kAmbiguousCoordinate,
            "several robots of the plan have the coordinate of " + names +
                ": write it with the robot's id, " + names};
  return {ErrorCode::invalid_argument, reasons::kMissingCoordinate,
          "the request lacks " + names + ", which the plan needs: state it, 0 included"};
}

Error beyond_limits_of(const JointSnapshot& snapshot, const JointTarget& target) {
  const auto& robot = snapshot.robots[target.refused_robot];
  const auto& answer = target.robot[target.refused_robot];
  const std::string axes = axes_text(robot, answer.unreachable);
  const auto first = static_cast<std::size_t>(std::countr_zero(answer.unreachable));
  if (first >= robot.fine.outputs.size())
    return {ErrorCode::out_of_range, reasons::kOutsideLimits, "beyond the soft limits"};
  const auto& output = robot.fine.outputs[first];
  return {ErrorCode::out_of_range, "OUTSIDE_LIMITS(" + axes + ")",
          axes + ": " + channel_name(robot.id, output.channel.name()) +
              " lies beyond its soft limits " + effects::number_text(output.min_mm) + " .. " +
              effects::number_text(output.max_mm) +
              " mm: the pose cannot be reached; ask for one within the travel"};
}

// The names that a rule of the cell refuses, at the pose and at the datum's zero.
std::string refused_names(const JointSnapshot& snapshot, const JointTarget& target, bool old) {
  std::string out;
  std::vector<std::string> seen;
  const auto add = [&](const std::string& text) {
    if (text.empty() || std::find(seen.begin(), seen.end(), text) != seen.end()) return;
    seen.push_back(text);
    out += (out.empty() ? "" : " ") + text;
  };
  for (std::size_t s = 0; s < snapshot.steps.size(); ++s)
    add(inputs_text(snapshot.robots[snapshot.steps[s].from].id, snapshot.steps[s].predicts,
                    old ? target.step_stale[s] | target.step_missing[s]
                        : target.step_outside[s] | snapshot.steps[s].predicts.zero_outside));
  for (std::size_t r = 0; r < target.robots; ++r)
    visit_answering(
        snapshot.robots[r], target.robot[r], [&](const Snapshot& model, const ModelFlags& bits) {
          add(inputs_text(snapshot.robots[r].id, model,
                          old ? bits.stale | bits.missing : bits.outside | model.zero_outside));
        });
  return out;
}

std::string changed_parts_of(const JointSnapshot& snapshot) {
  for (const auto& robot : snapshot.robots)
    if (!robot.fine.changed_parts.empty())
      return robot.fine.changed_parts;
    else if (robot.coarse && !robot.coarse->changed_parts.empty())
      return robot.coarse->changed_parts;
  for (const auto& step : snapshot.steps)
    if (!step.predicts.changed_parts.empty()) return step.predicts.changed_parts;
  return "";
}

}  // namespace

Result<JointName> joint_name(const JointSnapshot& snapshot, std::string_view name) {
  const std::string_view robot = robot_of(name);
  const auto variable = compensation::variable_named(without_robot(name));
  if (variable && robot.empty()) return JointName{.variable = *variable};
  if (variable)
    if (const auto index = snapshot.robot_index(robot)) return JointName{*index, *variable};
  std::string ids;
  for (const auto& one : snapshot.robots)
    if (!one.id.empty()) ids += (ids.empty() ? "" : ", ") + one.id;
  return fail(
      ErrorCode::invalid_argument, reasons::kUnknownName,
      "found " + shown(name) +
          ", expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec, rz_arcsec or force_N" +
          (ids.empty() ? "" : ", or one of them after a robot's id and a dot; robots: " + ids));
}

std::string joint_channel(const JointSnapshot& snapshot, const JointTarget& target,
                          std::size_t output) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = target.robot[r];
    if (output >= robot.first && output < robot.first + robot.outputs)
      return channel_name(snapshot.robots[r].id,
                          snapshot.robots[r].fine.outputs[output - robot.first].channel.name());
  }
  return "";
}

void append_joint_flags(std::string& out, const JointSnapshot& snapshot, const JointTarget& target,
                        char between) {
  FlagText text(out, between);
  for (std::size_t s = 0; s < snapshot.steps.size(); ++s)
    if (target.step_flags[s] != 0)
      text.add_model(snapshot.robots[snapshot.steps[s].from].id, snapshot.steps[s].predicts,
                     {target.step_flags[s], target.step_outside[s], target.step_stale[s],
                      target.step_missing[s]});
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    const auto& answer = target.robot[r];
    if (answer.by == AnsweredBy::blend) text.add("BLENDED", robot.id);
    if (answer.by == AnsweredBy::coarse) text.add("COARSE", robot.id);
    if (answer.flags == 0) continue;
    visit_answering(robot, answer, [&](const Snapshot& model, const ModelFlags& bits) {
      text.add_model(robot.id, model, bits);
    });
    if ((answer.flags & compensation::kOutsideLimits) != 0)
      text.add(reasons::kOutsideLimits.view(),
               [&] { append_axes(out, robot, answer.unreachable); });
    if ((answer.flags & compensation::kUnknownLimits) != 0)
      text.add("UNKNOWN_LIMITS", [&] { append_axes(out, robot, answer.unlimited); });
  }
  if (std::ranges::any_of(target.ignored, [](std::uint32_t bits) { return bits != 0; }))
    text.add("IGNORED_COORDINATE", [&] { append_ignored(out, snapshot, target, between); });
}

std::vector<std::string> describe_joint_flags(const JointSnapshot& snapshot,
                                              const JointTarget& target) {
  std::string text;
  append_joint_flags(text, snapshot, target, ' ');
  std::vector<std::string> out;
  for (std::string_view rest = text; !rest.empty();) {
    const auto one = rest.substr(0, rest.find(','));
    out.emplace_back(one);
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
  }
  return out;
}

Error joint_refusal_error(const JointSnapshot& snapshot, const JointTarget& target) {
  switch (target.refusal) {
    case Refusal::none:
      break;
    case Refusal::no_model:
      if (snapshot.unserved) return *snapshot.unserved;
      return {ErrorCode::failed_precondition, reasons::kNoPlan,
              "no serving plan serves: add one and promote it (driftwise plan promote)"};
    case Refusal::missing_coordinate:
    case Refusal::not_finite:
      return refused_request(snapshot, target);
    case Refusal::outside_domain: {
      const std::string names = refused_names(snapshot, target, false);
      return {
          ErrorCode::out_of_range, reasons::kOutsideDomain,
          (names.empty() ? std::string("the pose") : names) +
              (snapshot.refuse_outside_domain
                   ? " outside what the plan's models were fitted on, and this cell refuses such "
                     "targets ([serving] refuse_outside_domain)"
                   : " so far outside what the plan's models were fitted on that they give no "
                     "number: ask within their domain")};
    }
    case Refusal::stale: {
      const std::string names = refused_names(snapshot, target, true);
      return {ErrorCode::failed_precondition, reasons::kStale,
              (names.empty() ? std::string("the conditions were not looked at in time")
                             : names + " too old or never read") +
                  ", and this cell refuses such targets ([serving] refuse_stale): look at the "
                  "scanner"};
    }
    case Refusal::no_pose:
      if (target.why) return *target.why;
      break;
    case Refusal::outside_limits:
      return beyond_limits_of(snapshot, target);
    case Refusal::configuration_changed:
      return {
          ErrorCode::failed_precondition, reasons::kConfigurationChanged,
          "the cell file has changed in what plan " + std::to_string(snapshot.plan.value) +
              " uses, and nobody has accepted it: " + changed_parts_of(snapshot) +
              ". Look at it and accept it (driftwise configuration accept), or put the file back"};
  }
  return {ErrorCode::internal, reasons::kNotRefused,
          "asked for the refusal of a joint target that was not refused"};
}

}  // namespace driftwise::plans
