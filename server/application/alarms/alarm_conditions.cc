#include "server/application/alarms/alarm_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "server/application/motion/loading.h"
#include "server/application/plumbing/pause_meter.h"
#include "server/application/ports/run_plan.h"

namespace driftwise::application {
namespace {

std::string run_subject(RunId run) { return fmt::format("run {}", run.value); }

void add_devices(const CellStatus& status, std::vector<AlarmCondition>& out,
                 std::set<std::string>& lost) {
  for (const auto& device : status.devices) {
    const bool tried = device.health.exchanges > 0 || device.health.errors > 0;
    if (device.health.link == LinkState::connected ||
        (!tried && device.health.link != LinkState::failed))
      continue;
    const std::string& id = device.description.id;
    lost.insert(id);
    if (device.unused) {
      out.push_back(
          {.level = AlarmLevel::notice,
           .kind = "device.unused",
           .subject = id,
           .message = fmt::format("{} at {} does not answer ({}); the set-up in use does "
                                  "not name it, and no run waits for it",
                                  id, device.description.address, device.health.last_error),
           .address = device.description.address});
      continue;
    }
    out.push_back(
        {.level = AlarmLevel::failed,
         .kind = "device.lost",
         .subject = id,
         .message = fmt::format("{} at {} does not answer ({}); it is tried again until it does",
                                id, device.description.address, device.health.last_error),
         .address = device.description.address});
  }
}

// Weights that are on their way have no force to be read; what measures the pose, and what moves
// the axes, belongs to a run under way, which reads it at its points. Of a robot that the run does
// not measure it reads nothing.
bool is_read_later(const CellStatus& status, const DeviceDescription& device) {
  if (!status.run) return false;
  if (is_read_by_runs(device.role())) return true;
  return device.role() == DeviceRole::load && status.run->phase == kChangingTheForce;
}

void add_stale_channels(const CellStatus& status, const std::set<std::string>& lost,
                        std::vector<AlarmCondition>& out) {
  for (const auto& latest : status.values) {
    const bool never = latest.at.utc_ns == 0;
    // Lengths are read when they are asked for: only what is read at intervals can be late.
    const auto device =
        std::find_if(status.devices.begin(), status.devices.end(),
                     [&](const DeviceStatus& one) { return one.description.id == latest.device; });
    if (never || !latest.stale || device == status.devices.end() ||
        device->description.period_s <= 0 || is_read_later(status, device->description))
      continue;
    const std::string channel = latest.channel.name();
    out.push_back(
        {.level = AlarmLevel::warning,
         .kind = "channel.stale",
         .subject = channel,
         .message = fmt::format("{} is {:.0f} s old, limit {:g} s{}: it joins no point and targets "
                                "carry a flag",
                                channel, latest.age_s, device->description.max_age_s,
                                lost.contains(latest.device)
                                    ? std::string()
                                    : fmt::format(", although {} answers", latest.device)),
         .device = latest.device});
  }
}

// Readings join by the measured offset whatever it is; people who compare the device's own log with
// the record need its clock right.
void add_device_clocks(const CellStatus& status, std::vector<AlarmCondition>& out) {
  for (const auto& device : status.devices) {
    if (!device.health.clock_offset) continue;
    const double off_s = seconds_from(*device.health.clock_offset - status.utc_offset);
    if (std::abs(off_s) <= device.health.max_clock_offset_s) continue;
    const std::string& id = device.description.id;
    out.push_back({AlarmLevel::warning, "device.clock", id,
                   fmt::format("the clock of {} is {:.1f} s {} this computer's UTC, limit {:g} s: "
                               "set it. Its readings count by the measured offset meanwhile",
                               id, std::abs(off_s), off_s < 0 ? "behind" : "ahead of",
                               device.health.max_clock_offset_s)});
  }
}

// The forced shutdown of a supply. upsd keeps it until it is started anew.
void add_forced_shutdowns(const CellStatus& status, std::vector<AlarmCondition>& out) {
  for (const auto& latest : status.values) {
    const auto device = std::ranges::find(status.devices, latest.device,
                                          [](const auto& one) { return one.description.id; });
    if (device == status.devices.end() || device->description.role() != DeviceRole::supply ||
        !latest.channel.symbol.ends_with("_forced") || latest.value != 1)
      continue;
    out.push_back({AlarmLevel::failed, "supply.forced", latest.device,
                   fmt::format("{} has announced a forced shutdown (FSD): it may switch off at any "
                               "moment, and a daemon that was started since does not end by it "
                               "while mains are there; look at the supply, then start upsd anew",
                               latest.device)});
  }
}

// The rules that a run goes by, whatever the cell file says now.
RunRules rules_of(const RunRecord& run) {
  const auto plan = read_run_plan(run.rules_json);
  return plan ? plan->rules : RunRules{};
}

void add_run(const RunProgress& progress, CellTime now, std::vector<AlarmCondition>& out) {
  const RunRecord& run = progress.run;
  // A cell that is beyond a limit for a moment, or whose channels have not been read yet after a
  // start, asks for nobody.
  constexpr double kWorthAnAlarm_s = 60;
  const bool is_moment = run.hold.kind == RunHold::Kind::condition &&
                         seconds_from(now - run.hold.at) < kWorthAnAlarm_s;
  // One that waits for a person is explained by no other alarm: it still waits when that is over.
  const bool asks_a_person = run.hold.kind == RunHold::Kind::trouble;
  if (run.state == RunState::waiting && !is_moment)
    out.push_back({.level = AlarmLevel::warning,
                   .kind = "run.waiting",
                   .subject = run_subject(run.id),
                   .message = fmt::format("run {} waits: {}", run.id.value, run.reason),
                   .detail = asks_a_person ? std::string() : run.reason});
  // A person who paused a run knows of it; nobody knows of one that the daemon stopped.
  const bool by_daemon =
      run.hold.kind == RunHold::Kind::trouble || run.hold.kind == RunHold::Kind::restart;
  if (run.state == RunState::paused)
    out.push_back(
        {by_daemon ? AlarmLevel::warning : AlarmLevel::notice, "run.paused", run_subject(run.id),
         fmt::format("run {} stands still: {}; resume it to go on", run.id.value, run.reason)});
  if (run.given_up > 0) {
    const RunRules rules = rules_of(run);
    out.push_back({AlarmLevel::warning, "gate.given_up", run_subject(run.id),
                   fmt::format("run {} gave up {} of {} rows that failed the gate within all "
                               "budgets (limits of this run: spread {:g} nm, readback {:g} nm "
                               "peak to peak over {:g} s): 'driftwise run attempts {}' says why",
                               run.id.value, run.given_up, run.rows, rules.max_spread_nm,
                               rules.quiet_nm, rules.settle_s, run.id.value)});
  }
}

}  // namespace

std::vector<AlarmCondition> alarm_conditions(const CellStatus& status) {
  std::vector<AlarmCondition> out;
  std::set<std::string> lost;
  add_devices(status, out, lost);
  add_stale_channels(status, lost, out);
  add_device_clocks(status, out);
  add_forced_shutdowns(status, out);
  if (status.run) add_run(*status.run, status.now.utc, out);
  if (status.recent_pause_s >= PauseMeter::kAlarm_s)
    out.push_back(
        {AlarmLevel::failed, "daemon.paused", "daemon",
         fmt::format("for {:.1f} s the daemon answered nobody, a stop neither (limit {:g} "
                     "s): look for an overloaded computer or disk; if it was not, report "
                     "what was asked of the daemon then",
                     status.recent_pause_s, PauseMeter::kAlarm_s)});
  return out;
}

void QualityTrend::take(const RunProgress& progress) {
  if (progress.run.id !=
      run_) {  // what it took before is not these points': the daemon began again
    *this = {};
    run_ = progress.run.id;
    accepted_ = progress.run.accepted;
    attempts_before_ = progress.run.attempts;
  }
  if (progress.run.accepted <= accepted_ || is_missing(progress.last_spread_nm)) return;
  accepted_ = progress.run.accepted;
  spreads_nm_.push_back(progress.last_spread_nm);
  attempts_.push_back(progress.run.attempts);
  if (spreads_nm_.size() > kPoints) {
    attempts_before_ = attempts_.front();
    spreads_nm_.erase(spreads_nm_.begin());
    attempts_.erase(attempts_.begin());
  }
  if (spreads_nm_.size() < kPoints) return;
  many_attempts_ = attempts_each() > (many_attempts_ ? kFewAttempts : kManyAttempts);
}

double QualityTrend::attempts_each() const {
  return static_cast<double>(attempts_.back() - attempts_before_) / kPoints;
}

std::optional<AlarmCondition> QualityTrend::condition(double max_spread_nm) const {
  if (spreads_nm_.size() < kPoints) return std::nullopt;
  std::vector<double> sorted = spreads_nm_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  if (*middle <= 0.8 * max_spread_nm && !many_attempts_) return std::nullopt;
  return AlarmCondition{
      AlarmLevel::warning, "gate.spread", run_subject(run_),
      fmt::format("the last {} points of run {} have a median spread of {:.1f} nm (limit {:g} nm) "
                  "and took {:.1f} attempts each: look for turbulence or vibration",
                  kPoints, run_.value, *middle, max_spread_nm, attempts_each())};
}

}  // namespace driftwise::application
