#include "server/application/upkeep/wall_clock_watch.h"

#include <fmt/format.h>

#include "server/application/plumbing/task_group.h"

namespace driftwise::application {
namespace {

constexpr double kLook_s = 0.5;  // of wall time

std::string step_sentence(Nanoseconds step, UtcTime before, UtcTime after, const char* when) {
  return fmt::format(
      "the wall clock was set {} by {:.3f} s{}, from {} to {}: UTC is mapped anew from here on; "
      "waits, ages, leases and the order of rows follow the monotonic clock and are not touched",
      step.count() < 0 ? "back" : "forward", std::abs(seconds_from(step)), when, to_iso8601(before),
      to_iso8601(after));
}

bool is_step(Nanoseconds step) {
  return step >= WallClockWatch::kEvent || step <= -WallClockWatch::kEvent;
}
bool is_alarm(Nanoseconds step) {
  return step > WallClockWatch::kAlarm || step < -WallClockWatch::kAlarm;
}

AlarmCondition alarm_of(std::string sentence) {
  return {AlarmLevel::warning, "clock.stepped", "wall clock", std::move(sentence)};
}

UtcMap map_of(const std::vector<ClockRecord>& records) {
  std::vector<UtcStretch> stretches;
  for (const auto& record : records) stretches.push_back({record.from, record.offset});
  return UtcMap(std::move(stretches));
}

}  // namespace

ClockStart begin_cell_time(Clock& clock, std::vector<ClockRecord> before,
                           CellTime newest_on_record) {
  const auto boot = clock.since_boot();
  ClockRecord now;
  now.boot = boot.name;
  now.boot_ns = boot.ns;
  now.ahead_ns = clock.wall_ahead_ns();
  const CellTime utc{boot.ns + now.ahead_ns};
  const bool same_boot = !before.empty() && !boot.name.empty() && before.back().boot == boot.name;
  if (same_boot) {
    const auto& last = before.back();
    clock.begin_at(last.from + Nanoseconds(boot.ns - last.boot_ns), newest_on_record);
    now.step = Nanoseconds(now.ahead_ns - last.ahead_ns);
    if (!is_step(now.step)) now.step = Nanoseconds(0);
  } else {
    clock.begin_at(utc, newest_on_record);
  }
  now.from = clock.now().utc;
  if (!clock.is_simulated())
    now.offset = utc - now.from;
  else if (same_boot)
    now.offset = before.back().offset + now.step;
  if (!is_step(now.offset)) now.offset = Nanoseconds(0);
  before.push_back(now);
  clock.map_utc(map_of(before));
  return {std::move(before)};
}

WallClockWatch::WallClockWatch(asio::any_io_executor executor, Clock& clock, StoreWriter& writer,
                               EventLog& events, TaskGroup& tasks,
                               std::function<void(AlarmCondition)> alarm)
    : executor_(executor),
      clock_(clock),
      writer_(writer),
      events_(events),
      tasks_(tasks),
      alarm_(std::move(alarm)),
      ended_(executor) {}

void WallClockWatch::start(ClockStart start) {
  records_ = std::move(start.records);
  tell_of_start(records_.back());
  tasks_.spawn(watch());
}

void WallClockWatch::tell_of_start(const ClockRecord& start) {
  const UtcTime utc = clock_.utc(start.from);
  if (start.step.count() != 0) {
    auto sentence =
        step_sentence(start.step, {utc.ns - start.step.count()}, utc, " while the daemon was away");
    events_.record_own("clock.stepped", sentence);
    if (is_alarm(start.step)) alarm_(alarm_of(std::move(sentence)));
  } else if (!clock_.is_simulated() && start.offset < -kAlarm &&
             (records_.size() < 2 || records_[records_.size() - 2].boot != start.boot)) {
    auto sentence = fmt::format(
        "the wall clock says {}, {:.3f} s before the newest entry on record: cell time goes on "
        "behind the record, and UTC is mapped to the wall clock; set the computer's clock",
        to_iso8601(utc), -seconds_from(start.offset));
    events_.record_own("clock.behind", sentence);
    alarm_({AlarmLevel::warning, "clock.behind", "wall clock", std::move(sentence)});
  }
}

void WallClockWatch::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<void> WallClockWatch::watch() {
  while (!ending_) {
    const auto pause = nanoseconds_from_s(kLook_s * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + pause, ended_);
    if (!ending_) co_await look();
  }
}

Awaitable<void> WallClockWatch::look() {
  const auto& last = records_.back();
  const std::int64_t ahead_ns = clock_.wall_ahead_ns();
  const Nanoseconds step(ahead_ns - last.ahead_ns);
  if (!is_step(step)) co_return;
  const auto boot = clock_.since_boot();
  const CellTime now = clock_.now().utc;
  const UtcTime before = clock_.utc(now);
  const ClockRecord record{now, last.offset + step, step, boot.name, boot.ns, ahead_ns};
  records_.push_back(record);
  clock_.map_utc(map_of(records_));
  auto sentence = step_sentence(step, before, clock_.utc(now), "");
  events_.record_own("clock.stepped", sentence);
  if (is_alarm(step)) alarm_(alarm_of(std::move(sentence)));
  const auto stored = co_await writer_.clocks().add_clock(record);
  if (!stored)  // the next start compares with the record before it and finds the step again
    events_.record_own("daemon.trouble",
                       "storing a step of the wall clock: " + stored.error().message);
}

}  // namespace driftwise::application
