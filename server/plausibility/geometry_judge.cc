#include "server/plausibility/geometry_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace driftwise::plausibility {
namespace {

constexpr double kMmPerUm = 1e-3;

const double* value_of(const std::vector<ChannelValue>& values, const std::string& channel) {
  const auto found = std::ranges::find(values, channel, &ChannelValue::channel);
  return found == values.end() || is_missing(found->value) ? nullptr : &found->value;
}

// The farthest that a motor is from where the pose is 0, in its own unit.
double way_from_zero(const std::vector<ChannelValue>& q, const std::vector<ChannelValue>& q_zero) {
  double farthest = 0;
  for (const auto& now : q)
    if (const double* zero = value_of(q_zero, now.channel))
      farthest = std::max(farthest, std::abs(now.value - *zero));
  return farthest;
}

}  // namespace

bool GeometryComparison::disagrees() const {
  return std::ranges::any_of(outputs, [](const Output& one) {
    return !(std::abs(one.off_mm) <= one.limit_mm);  // no pose reaches it: NaN
  });
}

std::string GeometryComparison::sentence() const {
  std::string text;
  for (const auto& one : outputs) {
    if (std::abs(one.off_mm) <= one.limit_mm) continue;
    text += text.empty() ? "" : ", ";
    text += fmt::format("{} by the measured pose is {:+.4g} {} from its readback (limit {:.3g})",
                        one.channel.name(), one.off_mm, one.channel.unit, one.limit_mm);
  }
  return text +
         ": the pose does not follow the axes as the declared geometry has it: look at the "
         "interferometers and the scales; limits: [plausibility] geometry_um, geometry_pct";
}

GeometryJudge::GeometryJudge(const CellDescription& cell) : rules_(cell.plausibility) {
  if (!cell.has_several_robots()) {
    if (cell.kinematics) add(*cell.kinematics, "");
    return;
  }
  for (const auto& robot : cell.robots)
    if (robot.kinematics) add(*robot.kinematics, robot.id + ".");
}

void GeometryJudge::add(const KinematicsDescription& geometry, const std::string& prefix) {
  auto made = kinematics::make_mechanism(geometry);
  if (!made) return;
  robots_.push_back({prefix, *made, kinematics::nominal_values((*made)->parameters())});
}

GeometryComparison GeometryJudge::compare(const std::vector<ChannelValue>& pose,
                                          const std::vector<ChannelValue>& q,
                                          const std::vector<ChannelValue>& q_zero) const {
  GeometryComparison comparison;
  for (const auto& robot : robots_) compare(robot, pose, q, q_zero, comparison);
  return comparison;
}

void GeometryJudge::compare(const Robot& robot, const std::vector<ChannelValue>& pose,
                            const std::vector<ChannelValue>& all_q,
                            const std::vector<ChannelValue>& q_zero,
                            GeometryComparison& comparison) const {
  std::vector<ChannelValue> q = all_q;
  std::erase_if(q, [&robot](const auto& one) { return !one.channel.starts_with(robot.prefix); });
  const bool from_pose = !robot.mechanism->predicts_pose();
  std::vector<double> inputs, inputs_at_zero;
  for (const auto& input : robot.mechanism->inputs()) {
    const std::string name = robot.prefix + input.name();
    const double* now = value_of(from_pose ? pose : q, name);
    const double* zero = from_pose ? nullptr : value_of(q_zero, name);
    if (!now || (!from_pose && !zero)) return;
    inputs.push_back(*now);
    inputs_at_zero.push_back(zero ? *zero : 0.0);
  }
  const auto there = robot.mechanism->predict(inputs, robot.values).value;
  const auto at_zero = robot.mechanism->predict(inputs_at_zero, robot.values).value;
  const double way = way_from_zero(q, q_zero);
  for (std::size_t i = 0; i < robot.mechanism->outputs().size(); ++i) {
    Channel channel = robot.mechanism->outputs()[i];
    channel.symbol = robot.prefix + channel.symbol;
    const double* measured = value_of(from_pose ? q : pose, channel.name());
    const double* zero = from_pose ? value_of(q_zero, channel.name()) : nullptr;
    if (channel.unit != "mm" || !measured || (from_pose && !zero)) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const double moved = *measured - (zero ? *zero : 0.0);
    comparison.outputs.push_back({std::move(channel), there[at] - at_zero[at] - moved,
                                  rules_.geometry_um * kMmPerUm + rules_.geometry_pct / 100 * way});
  }
}

}  // namespace driftwise::plausibility
