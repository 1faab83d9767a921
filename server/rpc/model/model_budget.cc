#include "server/rpc/model/model_budget.h"

#include "server/compensation/snapshot_builder.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {
namespace {

constexpr CellTime kAnyTime{1'000'000'000'000'000'000};

// Where between the ends of each range the pose lies: 0.5 the middle, 1 the upper end.
compensation::TargetRequest request_at(const compensation::Snapshot& snapshot, double share,
                                       v1::PoseBudget& out) {
  compensation::TargetRequest request;
  for (const auto& input : snapshot.inputs) {
    if (!input.variable) continue;
    const double value = input.min + share * (input.max - input.min);
    request.set(*input.variable, value);
    auto& added = *out.add_pose();
    added.set_channel(compensation::channel_of(*input.variable).name());
    added.set_value(value);
  }
  return request;
}

}  // namespace

void add_budgets(const calibration::Model& model, const CellDescription& cell,
                 v1::GetModelResponse& out) {
  auto builder = compensation::SnapshotBuilder::create(model, ModelId{0}, cell);
  if (!builder) return;
  builder->keep_model_datum();
  for (const auto& range : model.domain) {
    const ChannelValue middle{range.channel.name(), 0.5 * (range.min + range.max)};
    builder->observe(std::span(&middle, 1), kAnyTime);
  }
  const auto snapshot = builder->build(kAnyTime);
  for (const auto& [place, share] : {std::pair{"centre", 0.5}, std::pair{"corner", 1.0}}) {
    v1::PoseBudget budget;
    budget.set_place(place);
    const auto request = request_at(snapshot, share, budget);
    v1::Target target;
    if (!answer_target(snapshot, request, true, target)) continue;
    *budget.mutable_coordinates() = std::move(*target.mutable_coordinates());
    *out.add_budgets() = std::move(budget);
  }
}

void add_declared(const CellDescription& cell, v1::GetModelResponse& out) {
  const auto add = [&](const std::string& device, const std::string& channel, const char* name,
                       double value) {
    if (value == 0) return;
    auto& added = *out.add_declared();
    added.set_device_id(device);
    added.set_channel(channel);
    added.set_name(name);
    added.set_value(value);
  };
  for (const auto& device : cell.devices) {
    for (const auto& axis : device.axes())
      add(device.id, axis.channel.name(), "u_scale_nm", axis.u_scale_nm);
    if (device.length()) {
      add(device.id, device.length()->channel.name(), "u_length_nm", device.length()->u_length_nm);
      add(device.id, device.length()->channel.name(), "u_drift_nm_per_h",
          device.length()->u_drift_nm_per_h);
      add(device.id, device.length()->channel.name(), "u_drift_nm_per_k",
          device.length()->u_drift_nm_per_k);
    }
    for (const auto& angle : device.angles())
      add(device.id, angle.channel.name(), "u_arcsec", angle.u_arcsec);
    for (const auto& probe : device.probes())
      add(device.id, probe.channel.name(), "u_k", probe.u_k);
  }
  if (cell.correction) {
    for (const auto& beam : cell.correction->beams) {
      add("beam", beam.length.name(), "u_offset_mm", beam.u_offset_mm);
      add("beam", beam.length.name(), "u_direction_arcsec", beam.u_direction_arcsec);
      add("beam", beam.length.name(), "u_flatness_nm", beam.u_flatness_nm);
    }
  }
  if (cell.load) add("load", "force_N", "u_n", cell.load->u_n);
}

}  // namespace driftwise::rpc
