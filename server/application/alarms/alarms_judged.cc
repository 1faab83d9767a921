// Conditions on which an alarm of before the daemon's start ends by its source's silence. A source
// keeps in memory since when a condition holds; the store keeps only that it held.

#include <algorithm>

#include "server/application/alarms/alarms_service.h"
#include "server/application/upkeep/disk_forecast.h"

namespace driftwise::application {
namespace {

constexpr std::string_view kServo = "servo of ";
constexpr double kAnHour_s = 3600;

bool is_one_of(const std::string& kind, std::initializer_list<std::string_view> kinds) {
  return std::ranges::find(kinds, kind) != kinds.end();
}

// The device answered or failed to, since the start. True where the cell has it no longer.
bool was_tried(const std::vector<DeviceStatus>& devices, const std::string& id) {
  const auto found = std::ranges::find_if(
      devices, [&id](const DeviceStatus& one) { return one.description.id == id; });
  return found == devices.end() || found->health.exchanges > 0 || found->health.errors > 0 ||
         found->health.link == LinkState::failed;
}

}  // namespace

// The moment that a run may stand at a limit without an alarm (alarm_conditions.cc) begins anew
// with the daemon.
bool AlarmsService::has_judged_run(const AlarmRecord& alarm) const {
  if (!start_is_done_) return false;
  const auto* run = engine_.record();
  const bool is_it =
      run != nullptr && engine_.busy() && alarm.subject == "run " + std::to_string(run->id.value);
  if (!is_it) return true;
  if (alarm.kind == "gate.spread") return quality_.has_judged(run->id);
  return alarm.kind != "run.waiting" || run->state != RunState::waiting;
}

bool AlarmsService::has_judged(const AlarmRecord& alarm) const {
  const auto& kind = alarm.kind;
  const auto value = [this](const std::string& channel) {
    const auto* latest = recorder_.history().latest(channel);
    return latest != nullptr && latest->at.utc_ns != 0;
  };
  if (is_one_of(kind, {"device.lost", "device.unused"}))
    return was_tried(bench_.status(), alarm.subject);
  if (kind == "device.clock")
    return std::ranges::all_of(bench_.status(), [&alarm](const DeviceStatus& one) {
      return one.description.id != alarm.subject || one.health.clock_offset;
    });
  if (kind == "motion.servo_off")
    return was_tried(bench_.status(), alarm.subject.starts_with(kServo)
                                          ? alarm.subject.substr(kServo.size())
                                          : alarm.subject);
  if (kind == "supply.forced")  // any value of it: they come in one answer
    return description_.find_device(alarm.subject) == nullptr ||
           std::ranges::any_of(recorder_.history().latest(), [&alarm](const auto& latest) {
             return latest.device == alarm.subject && latest.at.utc_ns != 0;
           });
  if (is_one_of(kind, {kChannelLimit, kCriticalChannelLimit}))
    return channel_alarms_.has_judged(kind, alarm.subject);
  // One answer says whether it is one; whether a value is frozen or jumps, only a row of them.
  if (is_one_of(kind,
                {"channel.stale", "reading.missing", "reading.not_finite", "reading.range"}) &&
      value(alarm.subject))
    return true;
  if (is_one_of(kind, {"run.waiting", "run.paused", "gate.given_up", "gate.spread"}))
    return has_judged_run(alarm);
  if (is_one_of(kind, {"model.damaged", "serving.trouble", "run.begins_soon", "run.moves_soon"}))
    return start_is_done_;
  // A datum that is opened ends it, as without a restart.
  if (kind == "motion.uncommanded") return doubts_.has_datum();
  if (kind == "load.on") return start_is_done_ && (!description_.load || force_now());
  if (kind == "stop.unconfirmed")
    return std::ranges::none_of(stops_.records(), [&alarm](const StopRecord& stop) {
      return stop.controller == alarm.subject;
    });
  if (is_one_of(kind, {"notify.failed", "watchdog.unreached"}))
    return notify_.has_judged(kind, alarm.subject);
  if (kind.starts_with("access.") || kind.starts_with("certificate.") || kind == "door.unreached")
    return access_.has_judged(kind, alarm.subject);
  return seconds_from(clock_.now().utc - started_) >= needed_s(alarm);
}

double AlarmsService::needed_s(const AlarmRecord& alarm) const {
  const auto& kind = alarm.kind;
  if (kind == "disk.forecast") return DiskForecast::kShortest_s + DatabaseUpkeep::kMeasure_s;
  if (kind == "backup.failed") return kAnHour_s;  // it is tried again every hour
  if (kind == "database.damaged") return DatabaseUpkeep::kFirstCheck_s;
  // Runs are checked again, by what is on record of all of them.
  if (kind == "model.doubtful") return Doubts::kForgotten_s;
  const bool is_doubt = kind.starts_with("reading.") || kind.ends_with(".disagrees");
  return is_doubt || kind == "channel.stale" ? Doubts::kForgotten_s : 0;
}

}  // namespace driftwise::application
