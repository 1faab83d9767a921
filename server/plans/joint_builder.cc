#include "server/plans/joint_builder.h"

#include <algorithm>

#include "server/compensation/basis_values.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/plans/robot_parts.h"
#include "server/plans/step_circles.h"

namespace driftwise::plans {
namespace {

using compensation::bit;
using compensation::Gives;
using compensation::Snapshot;
using compensation::Variable;

Error about_model(ModelId model, Error error) {
  error.message = "model " + std::to_string(model.value) + ": " + error.message;
  return error;
}

std::vector<std::string> outputs_of(const calibration::Model& model) {
  std::vector<std::string> names;
  for (const auto& output : model.outputs) names.push_back(output.channel.symbol);
  return names;
}

std::string listed_names(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

// The whole refuses by the cell's rules, not each part by itself.
Snapshot part_of_whole(Snapshot snapshot) {
  snapshot.refuse_stale = snapshot.refuse_outside_domain = snapshot.refuse_outside_limits = false;
  return snapshot;
}

Band band_of(const Blend& blend) {
  Band band;
  band.anchored = blend.anchored;
  for (const auto& edge : blend.band)
    band.part[band.parts++] = {
        edge.coordinate, edge.from,
        edge.to,         blend.anchored && edge.fade_to ? *edge.fade_to : edge.to,
        edge.centre,     edge.side};
  return band;
}

}  // namespace

Result<std::size_t> JointBuilder::add_part(ModelId model, const std::string& robot, Gives gives,
                                           const ModelsById& models, const CellDescription& cell) {
  const auto found = models.find(model);
  if (found == models.end())
    return fail(ErrorCode::not_found, reasons::kNoSuchModel,
                "there is no model " + std::to_string(model.value) +
                    ": 'driftwise model list' shows those there are");
  // The band's check, the anchor's shift and the slopes for added terms know terms alone.
  if (gives == Gives::motors && found->second.geometry)
    return tl::unexpected(about_model(
        model, {ErrorCode::failed_precondition, reasons::kNotAMotorModel,
                "a robot's geometry answers single targets; a plan is checked and blended by a "
                "regression's terms: name a model fitted without --method kinematic, or promote "
                "this one by itself (driftwise model promote)"}));
  auto own = part_of_robot(found->second, robot);
  if (!own) return tl::unexpected(about_model(model, own.error()));
  auto builder = compensation::SnapshotBuilder::create(std::move(*own), model,
                                                       part_of_robot(cell, robot), gives);
  if (!builder) return tl::unexpected(about_model(model, builder.error()));
  for (const auto& name : builder->slow_channels())
    if (std::ranges::find(slow_channels_, name) == slow_channels_.end())
      slow_channels_.push_back(name);
  parts_.push_back({model, robot, std::move(*builder)});
  return parts_.size() - 1;
}

Result<JointBuilder> JointBuilder::create(ServingPlan plan, PlanId id, const ModelsById& models,
                                          const CellDescription& cell) {
  JointBuilder made;
  made.id_ = id;
  made.rules_ = cell.serving;
  std::size_t motors = 0, terms = 0;
  for (const auto& robot : plan.robots) {
    RobotParts parts;
    DRIFTWISE_TRY(parts.fine, made.add_part(robot.model, robot.id, Gives::motors, models, cell));
    const auto fine_outputs = outputs_of(made.parts_[parts.fine].builder.model());
    motors += fine_outputs.size();
    if (robot.blend) {
      DRIFTWISE_TRY(const auto coarse,
                    made.add_part(robot.blend->coarse, robot.id, Gives::motors, models, cell));
      const auto coarse_outputs = outputs_of(made.parts_[coarse].builder.model());
      if (coarse_outputs != fine_outputs)
        return fail(ErrorCode::failed_precondition, reasons::kOtherOutputs,
                    "a blend of models " + std::to_string(robot.model.value) + " and " +
                        std::to_string(robot.blend->coarse.value) + ": one gives " +
                        listed_names(fine_outputs) + ", the other " + listed_names(coarse_outputs) +
                        "; blend models with the same motor coordinates in the same order");
      parts.coarse = coarse;
    }
    made.robots_.push_back(parts);
  }
  for (const auto& step : plan.steps) {
    DRIFTWISE_TRY(const auto part,
                  made.add_part(step.model, step.from, Gives::coordinates, models, cell));
    const auto given = outputs_of(made.parts_[part].builder.model());
    terms += given.size();
    for (const auto wanted : step.add)
      if (std::ranges::find(given, compensation::channel_of(wanted).symbol) == given.end())
        return fail(ErrorCode::failed_precondition, reasons::kNoOutput,
                    "model " + std::to_string(step.model.value) + " gives " + listed_names(given) +
                        " of " + step.from + ", no " + compensation::channel_of(wanted).symbol +
                        ": add only what the model predicts");
    made.steps_.push_back(part);
  }
  if (motors > 16 || terms > 16)
    return fail(ErrorCode::failed_precondition, reasons::kModelTooLarge,
                "the plan has " + std::to_string(motors) + " motor coordinates and " +
                    std::to_string(terms) + " predicted terms; 16 of each can be served");
  made.plan_ = std::move(plan);
  return made;
}

std::vector<std::string> JointBuilder::observed_channels() const {
  std::vector<std::string> names;
  for (const auto& part : parts_)
    for (const auto& name : part.builder.observed_channels())
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  return names;
}

Nanoseconds JointBuilder::memory() const {
  Nanoseconds longest{};
  for (const auto& part : parts_) longest = std::max(longest, part.builder.memory());
  return longest;
}

void JointBuilder::observe(std::span<const ChannelValue> values, CellTime at) {
  for (auto& part : parts_) part.builder.observe(values, at);  // slow channels carry no robot's id
}

std::vector<std::string> JointBuilder::anchor(std::span<const ChannelValue> values,
                                              const std::function<bool(ModelId)>& own) {
  std::vector<std::string> trouble;
  for (auto& part : parts_) {
    if (own(part.model)) {
      part.builder.keep_model_datum();
      continue;
    }
    if (const auto ok = part.builder.anchor(part_of_robot(values, part.robot)); !ok)
      trouble.push_back(about_model(part.model, ok.error()).message);
  }
  return trouble;
}

JointSnapshot JointBuilder::build(CellTime now,
                                  const std::function<void(ModelId, Snapshot&)>& finish) const {
  JointSnapshot out;
  out.plan = id_;
  out.built_at = now;
  out.refuse_stale = rules_.refuse_stale;
  out.refuse_outside_domain = rules_.refuse_outside_domain;
  out.refuse_outside_limits = rules_.refuse_outside_limits;
  out.valid_until = now + nanoseconds_from_s(2 * rules_.rebuild_period_s);
  const auto built = [&](std::size_t part) {
    auto snapshot = part_of_whole(parts_[part].builder.build(now));
    if (finish) finish(parts_[part].model, snapshot);
    return snapshot;
  };
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    JointSnapshot::Robot robot;
    robot.id = plan_.robots[r].id;
    robot.fine = built(robots_[r].fine);
    robot.needed = robot.fine.needed;
    if (robots_[r].coarse) {
      robot.coarse = built(*robots_[r].coarse);
      robot.same_terms = compensation::have_same_terms(robot.fine, *robot.coarse);
      robot.needed |= robot.coarse->needed;
      robot.band = band_of(*plan_.robots[r].blend);
      for (const auto& edge : plan_.robots[r].blend->band) robot.needed |= bit(edge.coordinate);
    }
    robot.stated = robot.needed;
    for (const auto& output : robot.fine.outputs)
      robot.motors.push_back(channel_name(robot.id, output.channel.symbol));
    out.robots.push_back(std::move(robot));
  }
  for (std::size_t s = 0; s < steps_.size(); ++s) {
    const auto& from = plan_.steps[s];
    JointSnapshot::Step step;
    step.from = *out.robot_index(from.from);
    step.to = *out.robot_index(from.to);
    step.predicts = built(steps_[s]);
    for (std::size_t i = 0; i < step.predicts.outputs.size(); ++i) {
      const auto variable = *compensation::variable_from(step.predicts.outputs[i].channel.symbol);
      step.output.push_back(variable);
      const bool added = std::ranges::find(from.add, variable) != from.add.end();
      if (added) step.added |= std::uint32_t{1} << i;
      step.terms.push_back(
          channel_name(added ? from.to : from.from, step.predicts.outputs[i].channel.symbol));
    }
    out.robots[step.from].stated |= step.predicts.needed;
    out.steps.push_back(std::move(step));
  }
  if (circles_of(out).any()) out.passes = kPassesOfCircle;
  if (plan_.z_taken_by) out.z_taken_by = out.robot_index(*plan_.z_taken_by);
  out.z_rest_mm = plan_.z_rest_mm;
  return out;
}

}  // namespace driftwise::plans
