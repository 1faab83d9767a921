// Names of robots and coordinates, flags and refusals of joint targets as texts.

#include <algorithm>
#include <bit>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/effects/term_order.h"
#include "server/plans/joint_target.h"

namespace driftwise::plans {
namespace {

using compensation::Refusal;
using compensation::Snapshot;
using compensation::Variable;

std::string inputs_text(const std::string& robot, const Snapshot& model, std::uint64_t bits) {
  std::string out;
  for (std::size_t i = 0; i < model.inputs.size(); ++i) {
    if ((bits >> i & 1) == 0) continue;
    const auto& input = model.inputs[i];
    out += (out.empty() ? "" : " ") +
           (input.variable ? channel_name(robot, input.channel.name()) : input.channel.name());
  }
  return out;
}

std::string coordinates_text(const std::string& robot, std::uint32_t bits) {
  std::string out;
  for (std::size_t v = 0; v < compensation::kVariables; ++v)
    if ((bits >> v & 1) != 0)
      out += (out.empty() ? "" : " ") + channel_name(robot, static_cast<Variable>(v));
  return out;
}

std::string axes_text(const JointSnapshot::Robot& robot, std::uint32_t bits) {
  std::string out;
  for (std::size_t i = 0; i < robot.fine.outputs.size(); ++i)
    if ((bits >> i & 1) != 0)
      out +=
          (out.empty() ? "" : "+") + channel_name(robot.id, robot.fine.outputs[i].channel.symbol);
  return out;
}

// The model whose bits a robot's answer holds.
const Snapshot& answering(const JointSnapshot::Robot& robot, const JointTarget::Robot& answer) {
  return answer.by == AnsweredBy::coarse || answer.by == AnsweredBy::blend ? *robot.coarse
                                                                           : robot.fine;
}

struct Bits {
  std::uint32_t flags;
  std::uint64_t outside, stale, missing;
};

void add_model_flags(const std::string& robot, const Snapshot& model, const Bits& bits,
                     std::vector<std::string>& out) {
  const auto add = [&](std::uint32_t flag, const std::string& name, std::uint64_t which) {
    if ((bits.flags & flag) == 0) return;
    const std::string whom = which != 0 ? inputs_text(robot, model, which) : robot;
    out.push_back(name + (whom.empty() ? "" : "(" + whom + ")"));
  };
  add(compensation::kOutsideDomain, reasons::kOutsideDomain, bits.outside);
  add(compensation::kStaleTemperature, "STALE_TEMPERATURE", bits.stale);
  add(compensation::kMissingTemperature, "MISSING_TEMPERATURE", bits.missing);
  add(compensation::kExpiredConditions, "EXPIRED_CONDITIONS", 0);
  add(compensation::kUnanchoredDatum, "UNANCHORED_DATUM", 0);
  add(compensation::kConfigurationChanged, reasons::kConfigurationChanged, 0);
}

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

// The names that a rule of the cell refuses.
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
                    old ? target.step_stale[s] | target.step_missing[s] : target.step_outside[s]));
  for (std::size_t r = 0; r < target.robots; ++r)
    add(inputs_text(
        snapshot.robots[r].id, answering(snapshot.robots[r], target.robot[r]),
        old ? target.robot[r].stale | target.robot[r].missing : target.robot[r].outside));
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
  const std::string_view robot = robot_of(name), local = without_robot(name);
  const auto cut = local.rfind('_');
  JointName found;
  const auto variable = cut == std::string_view::npos
                            ? std::nullopt
                            : compensation::variable_from(local.substr(0, cut));
  const bool known = variable && compensation::channel_of(*variable).unit == local.substr(cut + 1);
  if (known) found.variable = *variable;
  if (known && robot.empty()) return found;
  if (const auto index = snapshot.robot_index(robot); known && index) {
    found.robot = *index;
    return found;
  }
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

std::vector<std::string> describe_joint_flags(const JointSnapshot& snapshot,
                                              const JointTarget& target) {
  std::vector<std::string> out;
  for (std::size_t s = 0; s < snapshot.steps.size(); ++s)
    add_model_flags(snapshot.robots[snapshot.steps[s].from].id, snapshot.steps[s].predicts,
                    {target.step_flags[s], target.step_outside[s], target.step_stale[s],
                     target.step_missing[s]},
                    out);
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    const auto& answer = target.robot[r];
    const std::string whom = robot.id.empty() ? "" : "(" + robot.id + ")";
    if (answer.by == AnsweredBy::blend) out.push_back("BLENDED" + whom);
    if (answer.by == AnsweredBy::coarse) out.push_back("COARSE" + whom);
    add_model_flags(robot.id, answering(robot, answer),
                    {answer.flags, answer.outside, answer.stale, answer.missing}, out);
    if ((answer.flags & compensation::kOutsideLimits) != 0)
      out.push_back("OUTSIDE_LIMITS(" + axes_text(robot, answer.unreachable) + ")");
    if ((answer.flags & compensation::kUnknownLimits) != 0)
      out.push_back("UNKNOWN_LIMITS(" + axes_text(robot, answer.unlimited) + ")");
  }
  if (target.ignored != 0)
    out.push_back("IGNORED_COORDINATE(" + coordinates_text("", target.ignored) + ")");
  std::vector<std::string> once;
  for (auto& flag : out)
    if (std::find(once.begin(), once.end(), flag) == once.end()) once.push_back(std::move(flag));
  return once;
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
