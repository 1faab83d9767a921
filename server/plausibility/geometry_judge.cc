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
  if (!cell.kinematics) return;
  auto made = kinematics::make_mechanism(*cell.kinematics);
  if (!made) return;
  mechanism_ = std::move(*made);
  values_ = kinematics::nominal_values(mechanism_->parameters());
}

GeometryComparison GeometryJudge::compare(const std::vector<ChannelValue>& pose,
                                          const std::vector<ChannelValue>& q,
                                          const std::vector<ChannelValue>& q_zero) const {
  GeometryComparison comparison;
  if (!mechanism_) return comparison;
  const bool from_pose = !mechanism_->predicts_pose();
  std::vector<double> inputs, inputs_at_zero;
  for (const auto& input : mechanism_->inputs()) {
    const double* now = value_of(from_pose ? pose : q, input.name());
    const double* zero = from_pose ? nullptr : value_of(q_zero, input.name());
    if (!now || (!from_pose && !zero)) return comparison;
    inputs.push_back(*now);
    inputs_at_zero.push_back(zero ? *zero : 0.0);
  }
  const auto there = mechanism_->predict(inputs, values_).value;
  const auto at_zero = mechanism_->predict(inputs_at_zero, values_).value;
  const double way = way_from_zero(q, q_zero);
  for (std::size_t i = 0; i < mechanism_->outputs().size(); ++i) {
    const Channel& channel = mechanism_->outputs()[i];
    const double* measured = value_of(from_pose ? q : pose, channel.name());
    const double* zero = from_pose ? value_of(q_zero, channel.name()) : nullptr;
    if (channel.unit != "mm" || !measured || (from_pose && !zero)) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const double moved = *measured - (zero ? *zero : 0.0);
    comparison.outputs.push_back({channel, there[at] - at_zero[at] - moved,
                                  rules_.geometry_um * kMmPerUm + rules_.geometry_pct / 100 * way});
  }
  return comparison;
}

}  // namespace driftwise::plausibility
