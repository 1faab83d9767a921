#include "server/plans/plan_check.h"

#include <algorithm>
#include <set>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/plans/robot_parts.h"
#include "server/plans/step_circles.h"

namespace driftwise::plans {
namespace {

using compensation::bit;
using compensation::Snapshot;
using compensation::Variable;

std::string named(ModelId model) { return "model " + std::to_string(model.value); }

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

class Check {
 public:
  Check(const ServingPlan& plan, const ModelsById& models,
        const std::map<ModelId, std::vector<std::string>>& tools, const CellDescription& cell)
      : plan_(plan), models_(models), tools_(tools), cell_(cell) {}

  PlanCheck run() {
    look_at_robots();
    look_at_tools();
    if (!out_.findings.empty() && out_.findings.front().refuses) return std::move(out_);
    const auto builder = JointBuilder::create(plan_, PlanId{}, models_, cell_);
    if (!builder) {
      refuse(builder.error().reason, builder.error().message);
      return std::move(out_);
    }
    snapshot_ = builder->build(CellTime{});
    look_at_inputs(*builder);
    look_at_order();
    look_at_z();
    for (std::size_t r = 0; r < snapshot_.robots.size(); ++r) look_at_blend(r);
    look_at_step_domains();
    return std::move(out_);
  }

 private:
  void refuse(const std::string& reason, const std::string& message) {
    out_.findings.push_back({true, reason, message});
  }
  void ask(const std::string& reason, const std::string& message) {
    out_.findings.push_back({false, reason, message});
  }

  void look_at_robot(ModelId model, const std::string& robot, const std::string& use) {
    const auto found = models_.find(model);
    if (found == models_.end())
      return refuse(reasons::kNoSuchModel, "there is no " + named(model) +
                                               ": 'driftwise model list' shows those there are");
    for (const auto& other : robots_of(found->second))
      if (other != robot)
        refuse(reasons::kOtherRobot, named(model) + " has channels of " +
                                         (other.empty() ? std::string("a robot without an id")
                                                        : "robot " + shown(other)) +
                                         ", the plan uses it as " + use + " of robot " +
                                         shown(robot) + ": name a model of that robot" +
                                         (other.empty() ? ", or in a cell with one robot leave id "
                                                          "out of [[robot]]"
                                                        : ""));
  }

  void look_at_robots() {
    for (const auto& robot : plan_.robots) {
      look_at_robot(robot.model, robot.id, robot.blend ? "the fine model" : "the model");
      if (robot.blend) look_at_robot(robot.blend->coarse, robot.id, "the coarse model");
    }
    for (const auto& step : plan_.steps) look_at_robot(step.model, step.from, "a predicted motion");
  }

  std::string present_tool(const PlannedRobot& robot) const {
    if (!robot.tool.empty()) return robot.tool;
    for (const auto& one : cell_.robots)
      if (one.id == robot.id || (robot.id.empty() && cell_.robots.size() == 1)) return one.tool;
    return "";
  }

  void look_at_tools() {
    for (const auto& robot : plan_.robots) {
      const std::string tool = present_tool(robot);
      std::vector<ModelId> used = {robot.model};
      if (robot.blend) used.push_back(robot.blend->coarse);
      for (const auto& step : plan_.steps)
        if (step.from == robot.id) used.push_back(step.model);
      std::string first;
      ModelId first_model;
      for (const ModelId model : used) {
        const auto known = tools_.find(model);
        const bool none = known == tools_.end() || known->second.empty();
        if (none && !tool.empty())
          ask(reasons::kOtherTool, "nothing says with which tool " + named(model) +
                                       " was measured, and robot " + shown(robot.id) + " carries " +
                                       shown(tool));
        if (none) continue;
        for (const auto& measured : known->second) {
          if (!tool.empty() && measured != tool)
            refuse(reasons::kOtherTool, named(model) + " was measured with tool " +
                                            shown(measured) + ", robot " + shown(robot.id) +
                                            " carries " + shown(tool) +
                                            ": calibrate with this tool, or mount the other one");
          if (!first.empty() && measured != first)
            refuse(reasons::kOtherTool, named(model) + " was measured with tool " +
                                            shown(measured) + ", " + named(first_model) +
                                            " of the same robot with " + shown(first) +
                                            ": a robot's models belong to one tool");
          if (first.empty()) {
            first = measured;
            first_model = model;
          }
        }
      }
    }
  }

  std::set<std::string> measured_channels() const {
    std::set<std::string> found;
    for (const auto& device : cell_.devices) {
      for (const auto& channel : device.channels) found.insert(channel.name());
      for (const auto& probe : device.probes()) found.insert(probe.channel.name());
      for (const auto& quantity : device.quantities()) found.insert(quantity.channel.name());
    }
    if (const auto force = cell_.force_channel()) found.insert(force->name());
    return found;
  }

  void look_at_inputs(const JointBuilder& builder) {
    const auto measured = measured_channels();
    std::vector<std::string> lacking;
    for (const auto& name : builder.slow_channels())
      if (!measured.contains(name)) lacking.push_back(name);
    if (!lacking.empty())
      refuse(reasons::kNotMeasured,
             "the plan's models read " + listed(lacking) +
                 ", which this cell does not measure and no request states: name models without "
                 "it, or add the sensor to the cell file");
    for (std::size_t s = 0; s < snapshot_.steps.size(); ++s) {
      const auto& step = snapshot_.steps[s];
      const auto& from = snapshot_.robots[step.from];
      const auto& to = snapshot_.robots[step.to];
      for (std::size_t v = 0; v < compensation::kVariables; ++v) {
        const auto variable = static_cast<Variable>(v);
        if (variable == Variable::force) continue;
        if ((step.predicts.needed >> v & 1) != 0 && (from.needed >> v & 1) == 0)
          refuse(reasons::kNotMeasured,
                 "step " + std::to_string(s + 1) + ": " + named(step.predicts.model) + " reads " +
                     channel_name(from.id, variable) + ", which is neither wanted of robot " +
                     shown(from.id) + " nor measured: name a model of its wanted coordinates");
      }
      for (const auto added : plan_.steps[s].add)
        if ((to.needed & bit(added)) == 0)
          refuse(reasons::kNotMeasured, "step " + std::to_string(s + 1) + " adds to " +
                                            channel_name(to.id, added) +
                                            ", which no model of robot " + shown(to.id) +
                                            " reads: it would change nothing; leave it out of add");
    }
  }

  std::string fed_by(std::size_t a, std::size_t b) const {
    std::string names;
    for (const auto added : plan_.steps[a].add)
      if ((snapshot_.steps[b].predicts.needed & bit(added)) != 0)
        names += (names.empty() ? "" : ", ") +
                 channel_name(snapshot_.robots[snapshot_.steps[a].to].id, added);
    return names;
  }

  std::string sentence_of_circles(const StepCircles& circles) const {
    std::string out;
    for (std::size_t b = 0; b < snapshot_.steps.size(); ++b)
      for (std::size_t a = 0; a < snapshot_.steps.size(); ++a)
        if (circles.feeds(a, b) && circles.together(a, b))
          out += (out.empty() ? "" : "; ") + std::string("step ") + std::to_string(a + 1) + " (" +
                 named(snapshot_.steps[a].predicts.model) + ") changes " + fed_by(a, b) +
                 ", which step " + std::to_string(b + 1) + " (" +
                 named(snapshot_.steps[b].predicts.model) + ") reads";
    return out;
  }

  void look_at_order() {
    const std::size_t count = snapshot_.steps.size();
    const StepCircles circles = circles_of(snapshot_);
    if (circles.any()) {
      const double contraction = contraction_of(snapshot_);
      if (!(contraction <= kMostContraction))
        return refuse(reasons::kPlanCycle,
                      "the steps wait for one another: " + sentence_of_circles(circles) +
                          ". A pass through them leaves up to " + digits_text(contraction) +
                          " of what was wrong before it, at most " + digits_text(kMostContraction) +
                          " is accepted. Take a coordinate out of add, or a model that does not "
                          "read it");
    }
    // A circle's own steps stand in any order: they are gone through again.
    const auto before = [&circles](std::size_t a, std::size_t b) {
      return circles.feeds(a, b) && !circles.together(a, b);
    };
    // Steps that wait for none that is left are taken away, again and again.
    std::vector<std::size_t> order;
    std::set<std::size_t> left;
    for (std::size_t s = 0; s < count; ++s) left.insert(s);
    for (bool taken = true; taken;) {
      taken = false;
      for (const std::size_t s : left) {
        if (std::ranges::any_of(left, [&](std::size_t other) { return before(other, s); }))
          continue;
        order.push_back(s);
        left.erase(s);
        taken = true;
        break;
      }
    }
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t a = b + 1; a < count; ++a)
        if (before(a, b)) {
          std::string right;
          for (const std::size_t s : order)
            right += (right.empty() ? "" : ", ") + std::to_string(s + 1);
          return refuse(reasons::kPlanOrder,
                        "step " + std::to_string(b + 1) + " reads " + fed_by(a, b) +
                            ", which step " + std::to_string(a + 1) +
                            " changes after it: write the steps in the order " + right);
        }
  }

  void look_at_z() {
    std::vector<std::string> having;
    for (const auto& robot : snapshot_.robots)
      if ((robot.needed & bit(Variable::z)) != 0) having.push_back(robot.id);
    if (having.size() > 1 && !plan_.z_taken_by)
      refuse(reasons::kAmbiguousCoordinate,
             "robots " + listed(having) + " have z: say who takes a wanted z ([z] taken_by = \"" +
                 having.front() + "\")");
    if (plan_.z_taken_by && std::ranges::find(having, *plan_.z_taken_by) == having.end())
      refuse(reasons::kAmbiguousCoordinate,
             "[z] taken_by: no model of robot " + shown(*plan_.z_taken_by) + " reads z");
  }

  static const Snapshot::Input* input_of(const Snapshot& model, Variable variable) {
    for (const auto& input : model.inputs)
      if (input.variable == variable) return &input;
    return nullptr;
  }

  // What to write where the range lies nearly all on one side of the band's centre; empty: it does
  // not.
  static std::string range_hint(const BandPart& part, const Snapshot::Input& range) {
    constexpr double kNearlyAll = 0.1;
    if (part.side != BandSide::both ||
        reach_of(part, range.min, range.max) > kNearlyAll * (range.max - range.min))
      return {};
    const bool above = range.max - part.centre > part.centre - range.min;
    return "; its range, " + number_text(range.min) + " to " + number_text(range.max) +
           ", is on one side of the centre " + number_text(part.centre) + ": side = \"" +
           (above ? "above" : "below") +
           "\" counts there alone, centre = " + number_text(0.5 * (range.min + range.max)) +
           " on both sides of its middle";
  }

  static constexpr double kEqualEnds = 0.01;  // of a range's width

  void look_at_blend(std::size_t r) {
    const auto& robot = snapshot_.robots[r];
    if (!robot.coarse) return;
    const auto said = [&](Variable v) { return channel_name(robot.id, v); };
    const auto number = [](double value) { return number_text(value); };
    const std::size_t before = out_.findings.size();
    std::uint32_t in_band = 0;
    for (std::size_t p = 0; p < robot.band.parts; ++p) {
      const auto& part = robot.band.part[p];
      in_band |= bit(part.coordinate);
      const auto* fine = input_of(robot.fine, part.coordinate);
      const auto* coarse = input_of(*robot.coarse, part.coordinate);
      if (!fine || !coarse) {
        refuse(reasons::kOutsideDomain, "the band has " + said(part.coordinate) + ", which " +
                                            named(fine ? robot.coarse->model : robot.fine.model) +
                                            " does not read: a band is over coordinates of both");
        continue;
      }
      const double reach = reach_of(part, fine->min, fine->max);
      if (part.from > reach || part.to > kMostExtrapolation * reach)
        refuse(reasons::kOutsideDomain,
               "the band over " + said(part.coordinate) + " is from " + number(part.from) + " to " +
                   number(part.to) + ", and the fine " + named(robot.fine.model) +
                   " was fitted up to " + number(reach) + ": begin within that, and end at most " +
                   number(kMostExtrapolation) + " times as far out" + range_hint(part, *fine));
      const double far = robot.band.anchored ? part.fade_to : part.to;
      const double coarse_reach = reach_of(part, coarse->min, coarse->max);
      if (far > coarse_reach)
        refuse(reasons::kOutsideDomain,
               "the blend over " + said(part.coordinate) + " ends at " + number(far) +
                   ", and the coarse " + named(robot.coarse->model) + " was fitted up to " +
                   number(coarse_reach) + ": end it within that" + range_hint(part, *coarse));
      // Ranges have a margin in proportion to their width, so that equal ends differ a little.
      const double margin = kEqualEnds * (coarse->max - coarse->min);
      const bool ends_early = (part.side == BandSide::above && coarse->min < fine->min - margin) ||
                              (part.side == BandSide::below && coarse->max > fine->max + margin);
      if (ends_early)
        refuse(reasons::kOutsideDomain,
               "the band over " + said(part.coordinate) + " is on one side of " +
                   number(part.centre) + ", and on the other the fine " + named(robot.fine.model) +
                   " was fitted from " + number(fine->min) + " to " + number(fine->max) +
                   ", the coarse one from " + number(coarse->min) + " to " + number(coarse->max) +
                   ": there the fine model would still answer; count on both sides (side = "
                   "\"both\") from the middle of the fine range, centre = " +
                   number(0.5 * (fine->min + fine->max)));
    }
    for (const auto& fine : robot.fine.inputs) {
      if (!fine.variable || (in_band & bit(*fine.variable)) != 0) continue;
      const auto* coarse = input_of(*robot.coarse, *fine.variable);
      if (coarse && (coarse->min < fine.min || coarse->max > fine.max))
        refuse(reasons::kOutsideDomain,
               "the fine " + named(robot.fine.model) + " was fitted in " + said(*fine.variable) +
                   " from " + number(fine.min) + " to " + number(fine.max) +
                   ", the coarse one from " + number(coarse->min) + " to " + number(coarse->max) +
                   ": outside the fine range the fine model would still answer; put " +
                   said(*fine.variable) + " into the band");
    }
    if (out_.findings.size() > before) return;
    out_.bands.push_back(check_band(robot));
    if (!out_.bands.back().accepted())
      refuse(reasons::kModelsDisagree, sentence_of(out_.bands.back()));
  }

  void look_at_step_domains() {
    for (std::size_t s = 0; s < snapshot_.steps.size(); ++s) {
      const auto& step = snapshot_.steps[s];
      const auto& from = snapshot_.robots[step.from];
      const Snapshot& wanted = from.coarse ? *from.coarse : from.fine;
      for (const auto& input : step.predicts.inputs) {
        const auto* of_robot = input.variable ? input_of(wanted, *input.variable) : nullptr;
        if (of_robot && (of_robot->min < input.min || of_robot->max > input.max))
          ask(reasons::kOutsideDomain,
              "step " + std::to_string(s + 1) + ": " + named(step.predicts.model) +
                  " was fitted in " + channel_name(from.id, *input.variable) + " from " +
                  number_text(input.min) + " to " + number_text(input.max) +
                  ", the robot's own model from " + number_text(of_robot->min) + " to " +
                  number_text(of_robot->max) + ": targets between are extrapolated and flagged");
      }
    }
  }

  const ServingPlan& plan_;
  const ModelsById& models_;
  const std::map<ModelId, std::vector<std::string>>& tools_;
  const CellDescription& cell_;
  JointSnapshot snapshot_;
  PlanCheck out_;
};

}  // namespace

Result<void> PlanCheck::refusal() const {
  const PlanFinding* first = nullptr;
  std::string message;
  for (const auto& finding : findings) {
    if (!finding.refuses) continue;
    if (!first) first = &finding;
    message += (message.empty() ? "" : "; ") + finding.message;
  }
  if (!first) return {};
  const bool unknown = first->reason == reasons::kNoSuchModel;
  return fail(unknown ? ErrorCode::not_found : ErrorCode::failed_precondition, first->reason,
              message);
}

std::vector<std::string> PlanCheck::questions() const {
  std::vector<std::string> out;
  for (const auto& finding : findings)
    if (!finding.refuses) out.push_back(finding.message);
  return out;
}

PlanCheck check_plan(const ServingPlan& plan, const ModelsById& models,
                     const std::map<ModelId, std::vector<std::string>>& tools,
                     const CellDescription& cell) {
  return Check(plan, models, tools, cell).run();
}

}  // namespace driftwise::plans
