#include "server/rpc/commissioning/convert_commissioning.h"

#include "server/core/text/quantity_text.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::CheckVerdict finding_from(application::Finding finding) {
  switch (finding) {
    case application::Finding::good:
      return v1::CHECK_VERDICT_GOOD;
    case application::Finding::warning:
      return v1::CHECK_VERDICT_WARNING;
    case application::Finding::bad:
      return v1::CHECK_VERDICT_BAD;
    case application::Finding::unknown:
      return v1::CHECK_VERDICT_UNKNOWN;
  }
  return v1::CHECK_VERDICT_UNSPECIFIED;
}

const ProbeDescription* probe_of(const CellDescription& cell, const std::string& channel) {
  for (const auto& device : cell.devices)
    for (const auto& probe : device.probes())
      if (probe.channel.name() == channel) return &probe;
  return nullptr;
}

}  // namespace

v1::CheckCellResponse check_from(const application::CellCheck& check) {
  v1::CheckCellResponse out;
  for (const auto& item : check.items) {
    auto& one = *out.add_items();
    one.set_device_id(utf8_from(item.device));
    one.set_asked(utf8_from(item.asked));
    one.set_found(utf8_from(item.found));
    one.set_expected(utf8_from(item.expected));
    one.set_verdict(finding_from(item.finding));
    one.set_advice(utf8_from(item.advice));
  }
  out.set_verdict(finding_from(check.worst()));
  *out.mutable_check_time() = timestamp_from(check.at);
  return out;
}

v1::Jog jog_from(const application::JogState& jog, const CellDescription& cell) {
  v1::Jog out;
  out.set_id(jog.id);
  out.set_over(jog.over);
  out.set_released(jog.released);
  out.set_end_reason(utf8_from(jog.end_reason));
  out.set_step_count(jog.steps);
  const auto motors = cell.motor_channels();
  for (std::size_t i = 0; i < motors.size() && i < jog.q_mm.size(); ++i) {
    auto& one = *out.add_positions();
    one.set_channel(motors[i].name());
    one.set_position_mm(jog.q_mm[i]);
  }
  return out;
}

v1::CompareThermometersResponse thermometers_from(const application::ThermometerReport& report,
                                                  const CellDescription& cell) {
  v1::CompareThermometersResponse out;
  *out.mutable_from_time() = timestamp_from(report.from);
  *out.mutable_to_time() = timestamp_from(report.to);
  out.set_scan_count(report.scans);
  out.set_mean_degc(report.comparison.mean_degc);
  out.set_common_drift_k_per_h(report.comparison.common_drift_k_per_h);
  out.set_quiet(report.quiet);
  for (const auto& offset : report.comparison.offsets) {
    auto& one = *out.add_thermometers();
    one.set_channel(offset.channel);
    one.set_offset_k(offset.offset_k);
    one.set_u_offset_k(offset.u_offset_k);
    one.set_drift_k_per_h(offset.drift_k_per_h);
    one.set_u_drift_k_per_h(offset.u_drift_k_per_h);
    one.set_noise_k(offset.noise_k);
    one.set_out(offset.out);
    if (const auto* probe = probe_of(cell, offset.channel)) {
      one.set_part(probe->part);
      one.set_u_certificate_k(probe->u_k);
    }
    if (offset.out)
      one.set_sentence(offset.channel + " is " + digits_text(1000 * offset.offset_k, 3, true) +
                       " mK off the mean of all: look whether it sits in another temperature, "
                       "then at its connections and its certificate");
  }
  return out;
}

v1::Rest rest_from(const application::RestReport& report) {
  v1::Rest out;
  *out.mutable_begin_time() = timestamp_from(report.begin);
  if (report.end.utc_ns != 0) *out.mutable_end_time() = timestamp_from(report.end);
  out.set_begun_by(utf8_from(report.begun_by));
  out.set_end_reason(utf8_from(report.end_reason));
  *out.mutable_window_duration() = duration_from_s(report.limits.window_s);
  for (const auto& channel : report.channels) {
    auto& one = *out.add_channels();
    one.set_channel(channel.channel);
    one.set_unit(channel.unit);
    if (channel.rate) one.set_rate(*channel.rate);
    if (channel.u_rate) one.set_u_rate(*channel.u_rate);
    one.set_limit(channel.limit);
    if (channel.warm) *one.mutable_warm_time() = timestamp_from(*channel.warm);
    one.set_change(channel.change);
    one.set_change_unit(channel.change_unit);
  }
  if (report.warm) *out.mutable_warm_time() = timestamp_from(*report.warm);
  out.set_sentence(utf8_from(report.sentence));
  return out;
}

v1::Certificate certificate_from(const application::CertificateState& state) {
  v1::Certificate out;
  const auto& one = state.certificate;
  out.set_device_id(utf8_from(one.device));
  out.set_number(utf8_from(one.number));
  out.set_laboratory(utf8_from(one.laboratory));
  out.set_date(one.date);
  out.set_due_date(one.due);
  if (state.days_left) out.set_days_left(*state.days_left);
  return out;
}

}  // namespace driftwise::rpc
