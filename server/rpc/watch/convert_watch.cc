#include "server/rpc/watch/convert_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/rpc/cell/convert_cell.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::Alarm::Level level_from(AlarmLevel level) {
  switch (level) {
    case AlarmLevel::notice:
      return v1::Alarm::LEVEL_NOTICE;
    case AlarmLevel::warning:
      return v1::Alarm::LEVEL_WARNING;
    case AlarmLevel::failed:
      return v1::Alarm::LEVEL_FAILED;
  }
  return v1::Alarm::LEVEL_UNSPECIFIED;
}

v1::Alarm::Priority priority_from(AlarmPriority priority) {
  switch (priority) {
    case AlarmPriority::low:
      return v1::Alarm::PRIORITY_LOW;
    case AlarmPriority::medium:
      return v1::Alarm::PRIORITY_MEDIUM;
    case AlarmPriority::high:
      return v1::Alarm::PRIORITY_HIGH;
    case AlarmPriority::critical:
      return v1::Alarm::PRIORITY_CRITICAL;
  }
  return v1::Alarm::PRIORITY_UNSPECIFIED;
}

v1::Alarm::State alarm_state_from(AlarmState state) {
  switch (state) {
    case AlarmState::unacknowledged:
      return v1::Alarm::STATE_UNACKNOWLEDGED;
    case AlarmState::acknowledged:
      return v1::Alarm::STATE_ACKNOWLEDGED;
    case AlarmState::returned_unacknowledged:
      return v1::Alarm::STATE_RETURNED_UNACKNOWLEDGED;
    case AlarmState::normal:
      return v1::Alarm::STATE_NORMAL;
    case AlarmState::shelved:
      return v1::Alarm::STATE_SHELVED;
  }
  return v1::Alarm::STATE_UNSPECIFIED;
}

void describe_column(const DeviceDescription& device, const std::string& channel,
                     v1::ChannelLayout::Column& out) {
  out.set_interval_s(device.period_s);
  for (const auto& probe : device.probes())
    if (probe.channel.name() == channel) {
      out.set_place(probe.place);
      out.set_part(probe.part);
    }
  for (const auto& axis : device.axes())
    if (axis.channel.name() == channel) {
      out.set_min(axis.min_mm);
      out.set_max(axis.max_mm);
      out.set_part("robot");
    }
  if (device.length() && device.length()->channel.name() == channel) out.set_part("instrument");
}

}  // namespace

v1::Alarm alarm_from(const AlarmRecord& alarm) {
  v1::Alarm out;
  out.set_id(alarm.id.value);
  out.set_level(level_from(alarm.level));
  out.set_kind(alarm.kind);
  out.set_subject(utf8_from(alarm.subject));
  out.set_message(utf8_from(alarm.message));
  for (const auto& one : alarm.consequences) out.add_consequences(utf8_from(one));
  *out.mutable_since_time() = timestamp_from(alarm.since);
  if (alarm.cleared.utc_ns != 0) *out.mutable_cleared_time() = timestamp_from(alarm.cleared);
  if (alarm.acknowledged.utc_ns != 0) {
    *out.mutable_acknowledge_time() = timestamp_from(alarm.acknowledged);
    out.set_acknowledged_by(utf8_from(alarm.acknowledged_by));
  }
  out.set_priority(priority_from(alarm.priority()));
  out.set_state(alarm_state_from(alarm.state()));
  if (alarm.shelved_until.utc_ns != 0) {
    *out.mutable_shelved_until_time() = timestamp_from(alarm.shelved_until);
    out.set_shelved_by(utf8_from(alarm.shelved_by));
    out.set_shelve_reason(utf8_from(alarm.shelve_reason));
  }
  return out;
}

v1::Receiver receiver_from(const application::ReceiverStatus& receiver) {
  v1::Receiver out;
  out.set_name(utf8_from(receiver.name));
  out.set_way(utf8_from(receiver.way));
  out.set_waiting_count(receiver.waiting);
  if (receiver.delivered.utc_ns != 0)
    *out.mutable_deliver_time() = timestamp_from(receiver.delivered);
  if (receiver.failing_since.utc_ns != 0)
    *out.mutable_failing_time() = timestamp_from(receiver.failing_since);
  out.set_answer(utf8_from(receiver.answer));
  return out;
}

v1::Telling telling_from(const TellingRecord& telling) {
  v1::Telling out;
  out.set_alarm_id(telling.alarm.value);
  out.set_receiver(utf8_from(telling.receiver));
  if (telling.firing.utc_ns != 0) *out.mutable_firing_time() = timestamp_from(telling.firing);
  if (telling.last.utc_ns != 0) *out.mutable_last_time() = timestamp_from(telling.last);
  if (telling.resolved.utc_ns != 0) *out.mutable_resolved_time() = timestamp_from(telling.resolved);
  out.set_message_count(telling.count);
  out.set_failed_count(telling.failed);
  out.set_error(utf8_from(telling.error));
  return out;
}

v1::ChannelLayout layout_from(const application::CellStatus& status) {
  v1::ChannelLayout out;
  for (const auto& latest : status.values) {
    auto& column = *out.add_columns();
    column.set_channel(latest.channel.name());
    column.set_unit(latest.channel.unit);
    column.set_device_id(latest.device);
    const auto device =
        std::find_if(status.devices.begin(), status.devices.end(),
                     [&](const auto& one) { return one.description.id == latest.device; });
    const auto* description = device == status.devices.end() ? nullptr : &device->description;
    column.set_stale_after_s(application::stale_after_s(description, latest.device).value_or(0));
    if (description) describe_column(*description, column.channel(), column);
  }
  return out;
}

v1::ValuesUpdate values_update_from(const application::CellStatus& status) {
  v1::ValuesUpdate out;
  out.mutable_values()->Reserve(static_cast<int>(status.values.size()));
  out.mutable_age_ms()->Reserve(static_cast<int>(status.values.size()));
  for (const auto& latest : status.values) {
    out.add_values(latest.value);
    out.add_age_ms(latest.at.utc_ns == 0 ? -1 : std::llround(latest.age_s * 1000));
  }
  return out;
}

std::vector<v1::WatchEvent> watch_events_from(const RecordPage& page) {
  std::vector<v1::WatchEvent> out;
  for (const ModelId model : page.models)
    out.emplace_back().mutable_model()->set_model_id(model.value);
  for (const auto& promotion : page.promotions) {
    auto& change = *out.emplace_back().mutable_model();
    change.set_model_id(promotion.model ? promotion.model->value : 0);
    change.set_serving(true);
  }
  for (const auto& event : page.events) *out.emplace_back().mutable_record() = event_from(event);
  for (const auto& run : page.runs) *out.emplace_back().mutable_run() = run_from(run);
  for (const auto& one : page.attempts) {
    *out.emplace_back().mutable_attempt() = attempt_from(one.attempt);
    out.back().set_run_id(one.run.value);
  }
  for (const auto& point : page.points) *out.emplace_back().mutable_point() = point_from(point);
  for (const auto& alarm : page.alarms) *out.emplace_back().mutable_alarm() = alarm_from(alarm);
  for (const auto& job : page.diagnoses) {
    const bool done = job.state == JobState::done;
    *out.emplace_back().mutable_diagnosis() = diagnosis_progress_from(
        {job.id, job.state, done ? std::string("done") : job.reason, done ? 1.0 : 0.0});
  }
  for (const auto& job : page.improvements)
    *out.emplace_back().mutable_improvement() =
        improvement_progress_from({job.id, job.state, job.turns, job.reason});
  return out;
}

v1::Topic topic_of(const v1::WatchEvent& event) {
  switch (event.event_case()) {
    case v1::WatchEvent::kLayout:
    case v1::WatchEvent::kValues:
      return v1::TOPIC_VALUES;
    case v1::WatchEvent::kCell:
      return v1::TOPIC_CELL;
    case v1::WatchEvent::kProgress:
    case v1::WatchEvent::kRun:
    case v1::WatchEvent::kPoint:
    case v1::WatchEvent::kAttempt:
      return v1::TOPIC_RUNS;
    case v1::WatchEvent::kRecord:
      return v1::TOPIC_EVENTS;
    case v1::WatchEvent::kAlarm:
      return v1::TOPIC_ALARMS;
    case v1::WatchEvent::kModel:
      return v1::TOPIC_MODELS;
    case v1::WatchEvent::kDiagnosis:
    case v1::WatchEvent::kImprovement:
      return v1::TOPIC_DIAGNOSES;
    case v1::WatchEvent::EVENT_NOT_SET:
      break;
  }
  return v1::TOPIC_UNSPECIFIED;
}

v1::Series series_from(const SeriesColumn& column) {
  v1::Series out;
  out.set_channel(column.channel);
  if (const auto channel = parse_robot_channel(column.channel)) out.set_unit(channel->unit);
  const auto first = std::find_if(column.mean.begin(), column.mean.end(),
                                  [](double value) { return !is_missing(value); });
  const double base = first == column.mean.end() ? 0 : *first;
  out.set_base(base);
  const auto fill = [base](const std::vector<double>& from, auto& to) {
    to.Reserve(static_cast<int>(from.size()));
    for (const double value : from) to.Add(static_cast<float>(value - base));
  };
  fill(column.min, *out.mutable_min());
  fill(column.max, *out.mutable_max());
  fill(column.mean, *out.mutable_mean());
  out.mutable_count()->Reserve(static_cast<int>(column.count.size()));
  for (const std::int64_t count : column.count)
    out.add_count(static_cast<std::int32_t>(
        std::min<std::int64_t>(count, std::numeric_limits<std::int32_t>::max())));
  return out;
}

}  // namespace driftwise::rpc
