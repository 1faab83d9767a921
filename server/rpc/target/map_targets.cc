#include "server/rpc/target/map_targets.h"

#include <cmath>

#include "server/compensation/correction_parts.h"
#include "server/compensation/target.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostPositions = 200, kMostPoses = 10'000;

const compensation::Snapshot::Input* fast_input(const compensation::Snapshot& snapshot,
                                                const std::string& channel) {
  for (const auto& input : snapshot.inputs)
    if (input.variable && input.channel.name() == channel) return &input;
  return nullptr;
}

// The axis as used: its range that of the fitted domain where the request leaves it open.
Result<v1::MapAxis> used_axis(const compensation::Snapshot& snapshot, const v1::MapAxis& asked,
                              const char* field) {
  const auto bad = [&](const std::string& what) {
    return fail(ErrorCode::invalid_argument, reasons::kBadAxis, std::string(field) + ": " + what);
  };
  if (asked.count() < 2 || asked.count() > kMostPositions)
    return bad("count: found " + std::to_string(asked.count()) + ", expected 2 to 200");
  v1::MapAxis used = asked;
  const auto* input = fast_input(snapshot, asked.channel());
  if (input == nullptr && (!asked.has_from() || !asked.has_to()))
    return bad("the model does not depend on '" + asked.channel() +
               "', so it has no fitted range: state from and to, or take another channel");
  if (!asked.has_from()) used.set_from(input->min);
  if (!asked.has_to()) used.set_to(input->max);
  if (!std::isfinite(used.from()) || !std::isfinite(used.to()) || !(used.from() < used.to()))
    return bad("expected from < to, both finite");
  return used;
}

void add_domain(const compensation::Snapshot& snapshot, v1::MapTargetsResponse& response) {
  for (const auto& input : snapshot.inputs) {
    if (!input.variable) continue;
    auto& range = *response.add_domain();
    range.set_channel(input.channel.name());
    range.set_min(input.min);
    range.set_max(input.max);
  }
}

double position(const v1::MapAxis& axis, int index) {
  return axis.from() + (axis.to() - axis.from()) * index / (axis.count() - 1);
}

google::protobuf::RepeatedPtrField<v1::ChannelValue> first_pose(
    const v1::MapTargetsRequest& request, const v1::MapAxis& horizontal,
    const v1::MapAxis& vertical) {
  google::protobuf::RepeatedPtrField<v1::ChannelValue> pose;
  for (const auto& value : request.pose())
    if (value.channel() != horizontal.channel() && value.channel() != vertical.channel())
      *pose.Add() = value;
  for (const auto* axis : {&horizontal, &vertical}) {
    auto& value = *pose.Add();
    value.set_channel(axis->channel());
    value.set_value(axis->from());
  }
  return pose;
}

Result<void> add_pose(const compensation::Snapshot& snapshot,
                      const compensation::TargetRequest& request,
                      v1::MapTargetsResponse& response) {
  const auto target = compensation::compute_target(snapshot, request);
  if (target.refusal != compensation::Refusal::none)
    return tl::unexpected(compensation::refusal_error(snapshot, target));
  std::uint64_t fast = 0;
  for (std::size_t i = 0; i < snapshot.inputs.size(); ++i)
    if (snapshot.inputs[i].variable) fast |= std::uint64_t{1} << i;
  response.add_outside((target.outside & fast) != 0);
  response.add_unreachable(target.unreachable != 0);
  for (std::size_t i = 0; i < target.outputs; ++i) {
    auto& plane = *response.mutable_planes(static_cast<int>(i));
    plane.add_position_mm(target.q_mm[i]);
    plane.add_u90_nm(target.u90_nm(i));
    if (const auto parts = compensation::correction_parts(snapshot, request, i))
      plane.add_correction_nm(parts->sum_nm());
  }
  return {};
}

}  // namespace

Result<TargetMap> begin_map(const compensation::Snapshot& snapshot,
                            const v1::MapTargetsRequest& request,
                            v1::MapTargetsResponse& response) {
  if (snapshot.outputs.empty())
    return tl::unexpected(compensation::refusal_error(
        snapshot, compensation::compute_target(snapshot, compensation::TargetRequest{})));
  DRIFTWISE_TRY(const auto horizontal, used_axis(snapshot, request.horizontal(), "horizontal"));
  DRIFTWISE_TRY(const auto vertical, used_axis(snapshot, request.vertical(), "vertical"));
  if (horizontal.count() * vertical.count() > kMostPoses)
    return fail(ErrorCode::resource_exhausted, reasons::kTooManyPoses,
                "found " + std::to_string(horizontal.count() * vertical.count()) +
                    " poses, at most 10000 are mapped at once");
  *response.mutable_horizontal() = horizontal;
  *response.mutable_vertical() = vertical;
  for (const auto& output : snapshot.outputs)
    response.add_planes()->set_channel(output.channel.name());
  add_domain(snapshot, response);
  response.set_model_id(snapshot.model.value);
  *response.mutable_conditions_time() = timestamp_from(snapshot.built_at);
  return TargetMap{horizontal, vertical, first_pose(request, horizontal, vertical)};
}

Result<void> add_map_row(const compensation::Snapshot& snapshot, const TargetMap& map, int row,
                         CellTime now, v1::MapTargetsResponse& response) {
  auto pose = map.pose;
  for (int column = 0; column < map.horizontal.count(); ++column) {
    pose[pose.size() - 2].set_value(position(map.horizontal, column));
    pose[pose.size() - 1].set_value(position(map.vertical, row));
    // Checks the channels, and refuses an axis that stands twice.
    DRIFTWISE_TRY(auto asked, pose_from(pose, now));
    asked.show_unreachable = true;  // marked: a picture has no gaps
    DRIFTWISE_RETURN_IF_ERROR(add_pose(snapshot, asked, response));
  }
  return {};
}

Result<void> map_targets(const compensation::Snapshot& snapshot,
                         const v1::MapTargetsRequest& request, CellTime now,
                         v1::MapTargetsResponse& response) {
  DRIFTWISE_TRY(const auto map, begin_map(snapshot, request, response));
  for (int row = 0; row < map.vertical.count(); ++row)
    DRIFTWISE_RETURN_IF_ERROR(add_map_row(snapshot, map, row, now, response));
  return {};
}

}  // namespace driftwise::rpc
