#include "server/rpc/cell/convert_cell.h"

#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::Device::Link link_from(LinkState link) {
  switch (link) {
    case LinkState::disconnected:
      return v1::Device::LINK_DISCONNECTED;
    case LinkState::connecting:
      return v1::Device::LINK_CONNECTING;
    case LinkState::connected:
      return v1::Device::LINK_CONNECTED;
    case LinkState::failed:
      return v1::Device::LINK_FAILED;
  }
  return v1::Device::LINK_UNSPECIFIED;
}

v1::LatestValue latest_from(const application::LatestValue& latest) {
  v1::LatestValue out;
  out.set_channel(latest.channel.name());
  if (!is_missing(latest.value)) out.set_value(latest.value);
  if (latest.at.utc_ns != 0) {
    *out.mutable_measure_time() = timestamp_from(latest.at);
    *out.mutable_age_duration() = duration_from_s(latest.age_s);
  }
  out.set_stale(latest.stale);
  out.set_device_id(latest.device);
  return out;
}

}  // namespace

v1::Device device_from(const application::DeviceStatus& device) {
  const DeviceDescription& description = device.description;
  const DeviceHealth& health = device.health;
  v1::Device out;
  out.set_id(description.id);
  out.set_kind(description.kind);
  out.set_address(description.address);
  out.set_link(link_from(health.link));
  out.set_identity(utf8_from(health.identity));  // as the device sent it
  out.set_exchange_count(health.exchanges);
  out.set_error_count(health.errors);
  out.set_reconnect_count(health.reconnects);
  *out.mutable_last_latency_duration() = duration_from_s(health.last_latency_s);
  out.set_last_error(utf8_from(health.last_error));
  if (health.last_good.utc_ns != 0)
    *out.mutable_last_good_time() = timestamp_from(health.last_good);
  for (const auto& axis : description.axes()) {
    auto& added = *out.add_axes();
    added.set_channel(axis.channel.name());
    added.set_device_axis(axis.device_axis);
    added.set_min_mm(axis.min_mm);
    added.set_max_mm(axis.max_mm);
    added.set_u_scale_nm(axis.u_scale_nm);
  }
  for (const auto& probe : description.probes()) {
    auto& added = *out.add_probes();
    added.set_channel(probe.channel.name());
    added.set_input(probe.input);
    added.set_place(probe.place);
    added.set_part(probe.part);
    added.set_u_kelvin(probe.u_k);
  }
  if (description.length()) out.set_length_channel(description.length()->channel.name());
  for (const auto& angle : description.angles()) out.add_angle_channels(angle.channel.name());
  if (description.force()) out.set_force_channel(description.force()->name());
  return out;
}

v1::Lease lease_from(const application::Lease& lease) {
  v1::Lease out;
  out.set_token(lease.token);
  out.set_holder(lease.holder);
  out.set_peer(lease.peer);
  *out.mutable_end_time() = timestamp_from(lease.until);
  return out;
}

v1::Event event_from(const EventRecord& event) {
  v1::Event out;
  out.set_id(event.id.value);
  *out.mutable_event_time() = timestamp_from(event.at.utc);
  out.set_who(event.who);
  out.set_peer(event.from);
  out.set_what(event.what);
  out.set_detail(utf8_from(event.detail));
  if (event.run) out.set_run_id(event.run->value);
  return out;
}

v1::PendingStop pending_stop_from(const StopRecord& stop) {
  v1::PendingStop out;
  out.set_device_id(stop.controller);
  out.set_who(utf8_from(stop.who));
  out.set_cause(utf8_from(stop.cause));
  *out.mutable_request_time() = timestamp_from(stop.asked.utc);
  out.set_request_count(stop.presses);
  return out;
}

v1::Hold hold_from(const application::HoldStatus& hold) {
  using Phase = application::HoldWatch::Phase;
  const auto& rule = hold.rule;
  v1::Hold out;
  out.set_name(utf8_from(rule.name));
  out.set_channel(rule.channel);
  out.set_minus_channel(rule.minus);
  if (rule.above) out.set_above(*rule.above);
  if (rule.below) out.set_below(*rule.below);
  if (rule.release_above) out.set_release_above(*rule.release_above);
  if (rule.release_below) out.set_release_below(*rule.release_below);
  *out.mutable_for_duration() = duration_from_s(rule.for_s);
  *out.mutable_settle_duration() = duration_from_s(rule.settle_s);
  out.set_action(rule.action == HoldAction::end_daemon       ? v1::Hold::ACTION_END_DAEMON
                 : rule.action == HoldAction::stop           ? v1::Hold::ACTION_STOP
                 : rule.action == HoldAction::return_to_zero ? v1::Hold::ACTION_RETURN_TO_ZERO
                                                             : v1::Hold::ACTION_FINISH_POINT);
  out.set_phase(hold.phase == Phase::holding    ? v1::Hold::PHASE_HOLDING
                : hold.phase == Phase::exceeded ? v1::Hold::PHASE_EXCEEDED
                                                : v1::Hold::PHASE_CLEAR);
  if (hold.since.utc_ns != 0) *out.mutable_begin_time() = timestamp_from(hold.since);
  out.set_sentence(utf8_from(hold.sentence));
  out.set_outlook(utf8_from(hold.outlook));
  if (hold.aside_until.utc_ns != 0)
    *out.mutable_aside_until_time() = timestamp_from(hold.aside_until);
  out.set_aside_by(utf8_from(hold.aside_by));
  out.set_aside_reason(utf8_from(hold.aside_reason));
  out.set_advice(utf8_from(rule.advice));
  return out;
}

v1::GetStatusResponse status_from(const application::CellStatus& status) {
  v1::GetStatusResponse out;
  out.set_cell_name(status.name);
  out.set_version(status.version);
  out.set_config_hash(status.config_hash);
  out.set_web_address(status.web_address);
  *out.mutable_cell_time() = timestamp_from(status.now.utc);
  out.set_speed(status.speed);
  for (const auto& device : status.devices) *out.add_devices() = device_from(device);
  for (const auto& value : status.values) *out.add_values() = latest_from(value);
  if (status.run) *out.mutable_run() = progress_from(*status.run);
  if (status.lease) {
    *out.mutable_lease() = lease_from(*status.lease);
    out.mutable_lease()
        ->clear_token();  // whoever knows it may move: only TakeLease's answer holds it
  }
  if (status.serving) out.set_serving_model_id(status.serving->value);
  auto& database = *out.mutable_database();
  if (status.database.last_clean.utc_ns != 0)
    *database.mutable_clean_time() = timestamp_from(status.database.last_clean);
  database.set_table_count(status.database.tables);
  database.set_checked_table_count(status.database.tables_checked);
  for (const auto& trouble : status.database.troubles) database.add_troubles(utf8_from(trouble));
  for (const auto& sentence : status.attention) out.add_attention(utf8_from(sentence));
  for (const auto& stop : status.pending_stops) *out.add_pending_stops() = pending_stop_from(stop);
  return out;
}

}  // namespace driftwise::rpc
