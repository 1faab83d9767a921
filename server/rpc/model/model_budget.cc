#include "server/rpc/model/model_budget.h"

#include "server/compensation/model_budget.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {

void add_budgets(const calibration::Model& model, const CellDescription& cell,
                 v1::GetModelResponse& out) {
  const auto snapshot = compensation::model_snapshot(model, cell);
  if (!snapshot) return;
  for (const auto& place : compensation::budget_places(*snapshot)) {
    v1::Target target;
    if (!answer_target(*snapshot, place.request, true, target)) continue;
    auto& budget = *out.add_budgets();
    budget.set_place(place.name);
    add_values(place.pose, *budget.mutable_pose());
    *budget.mutable_coordinates() = std::move(*target.mutable_coordinates());
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
