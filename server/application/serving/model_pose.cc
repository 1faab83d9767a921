#include "server/application/serving/model_pose.h"

#include <algorithm>

#include "server/compensation/forward_pose.h"

namespace driftwise::application {
namespace {

const double* known_value(const std::vector<ChannelValue>& values, const std::string& channel) {
  const auto found = std::ranges::find(values, channel, &ChannelValue::channel);
  return found == values.end() || is_missing(found->value) ? nullptr : &found->value;
}

}  // namespace

std::optional<ModelPose> model_pose(const compensation::SnapshotBoard& board,
                                    const std::vector<ChannelValue>& values) {
  using compensation::Variable;
  const auto snapshot = board.read();
  if (!snapshot || snapshot->outputs.empty()) return std::nullopt;
  compensation::ForwardRequest request;
  for (const auto& output : snapshot->outputs) {
    const double* q_mm = known_value(values, output.channel.name());
    if (q_mm == nullptr) return std::nullopt;
    request.q_mm.push_back(*q_mm);
  }
  for (const auto variable : {Variable::rx, Variable::ry, Variable::rz, Variable::force})
    if (const double* value = known_value(values, compensation::channel_of(variable).name()))
      request.stated.set(variable, *value);
  const auto pose = compensation::forward_pose(*snapshot, request);
  constexpr auto kUnfit = compensation::kOutsideDomain | compensation::kZeroOutsideDomain |
                          compensation::kStaleTemperature | compensation::kMissingTemperature |
                          compensation::kExpiredConditions;
  if (!pose || (pose->target.flags & kUnfit) != 0) return std::nullopt;
  ModelPose out{snapshot->model, {}};
  for (const auto& one : pose->coordinates)
    out.values.push_back({compensation::channel_of(one.variable).name(), one.value});
  return out;
}

}  // namespace driftwise::application
