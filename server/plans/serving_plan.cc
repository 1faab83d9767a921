#include "server/plans/serving_plan.h"

#include <algorithm>

#include "server/core/text/quantity_text.h"
#include "server/effects/term_order.h"

namespace driftwise::plans {
namespace {

std::string number(double value) { return effects::number_text(value); }

std::string unit_of(compensation::Variable coordinate) {
  return compensation::channel_of(coordinate).unit;
}

std::string band_text(const PlannedRobot& robot) {
  std::string text;
  for (const auto& edge : robot.blend->band) {
    text += (text.empty() ? "" : ", ") + channel_name(robot.id, edge.coordinate) + " from " +
            number(edge.from) + " to " + number(edge.to) + " " + unit_of(edge.coordinate);
    if (edge.side != BandSide::both)
      text +=
          std::string(edge.side == BandSide::above ? " above " : " below ") + number(edge.centre);
    else if (edge.centre != 0)
      text += " away from " + number(edge.centre);
    if (robot.blend->anchored && edge.fade_to)
      text += " (shift fades out at " + number(*edge.fade_to) + ")";
  }
  return text;
}

}  // namespace

const PlannedRobot* ServingPlan::find(const std::string& robot) const {
  const auto found = std::ranges::find(robots, robot, &PlannedRobot::id);
  return found == robots.end() ? nullptr : &*found;
}

std::vector<ModelId> ServingPlan::models() const {
  std::vector<ModelId> all;
  for (const auto& robot : robots) {
    all.push_back(robot.model);
    if (robot.blend) all.push_back(robot.blend->coarse);
  }
  for (const auto& step : steps) all.push_back(step.model);
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

std::string channel_name(const std::string& robot, const std::string& channel) {
  return robot.empty() ? channel : robot + "." + channel;
}
std::string channel_name(const std::string& robot, compensation::Variable coordinate) {
  return channel_name(robot, compensation::channel_of(coordinate).name());
}

std::vector<std::string> steps_of(const ServingPlan& plan) {
  std::vector<std::string> out;
  if (plan.z_taken_by)
    out.push_back("robot " + *plan.z_taken_by +
                  " takes a z that names no robot; the others stand at " + number(plan.z_rest_mm) +
                  " mm unless the request says so");
  for (const auto& step : plan.steps) {
    std::string added;
    for (const auto coordinate : step.add)
      added += (added.empty() ? "" : ", ") + channel_name(step.from, coordinate) + " to " +
               channel_name(step.to, coordinate);
    out.push_back("model " + std::to_string(step.model.value) + " predicts parasitic motion of " +
                  step.from + (added.empty() ? "; nothing of it is added" : "; it adds " + added));
  }
  for (const auto& robot : plan.robots) {
    const std::string who = robot.id.empty() ? "the robot" : "robot " + robot.id;
    if (!robot.blend) {
      out.push_back("model " + std::to_string(robot.model.value) +
                    " gives the motor coordinates of " + who);
      continue;
    }
    out.push_back("models " + std::to_string(robot.model.value) + " (fine) and " +
                  std::to_string(robot.blend->coarse.value) + " (coarse" +
                  (robot.blend->anchored ? ", anchored to the fine one" : "") +
                  ") give the motor coordinates of " + who + ", blended over " + band_text(robot));
  }
  return out;
}

}  // namespace driftwise::plans
