#include "server/application/recording/recorder.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>
#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

// The air that an interferometer reads beside its length.
JudgedReading environment_of(JudgedReading reading) {
  const auto is_not_air = [](const std::string& channel) {
    const auto parsed = parse_robot_channel(channel);
    return !parsed || !(parsed->unit == "degC" || parsed->unit == "Pa" || parsed->unit == "hPa");
  };
  std::erase_if(reading.values, [&](const auto& one) { return is_not_air(one.channel); });
  std::erase_if(reading.rejected, [&](const auto& one) { return is_not_air(one.channel); });
  return reading;
}

}  // namespace

Recorder::Recorder(asio::any_io_executor executor, Clock& clock, DeviceBench& bench,
                   StoreWriter& writer, EventLog& events, LagMeter& lag, const PoseStage& pose,
                   TaskGroup& tasks)
    : executor_(executor),
      clock_(clock),
      bench_(bench),
      writer_(writer),
      events_(events),
      lag_(lag),
      pose_(pose),
      tasks_(tasks),
      ended_(executor),
      arrived_(executor) {}

void Recorder::start() {
  for (std::size_t device = 0; device < bench_.size(); ++device)
    if (period_s(device) > 0) tasks_.spawn(read_for_ever(device));
  tasks_.spawn(flush_for_ever());
}

void Recorder::shut_down() {
  ending_ = true;
  ended_.raise();
}

void Recorder::observe(const JudgedReading& reading) {
  if (pose_.is_identity()) return show(reading, reading.rejected);
  const Reading shown = pose_.under_raw_names(reading);
  auto rejected = reading.rejected;
  for (auto& value : rejected)
    for (std::size_t i = 0; i < reading.values.size(); ++i)
      if (reading.values[i].channel == value.channel) value.channel = shown.values[i].channel;
  show(shown, rejected);
}

void Recorder::show(const Reading& reading, std::span<const RejectedValue> rejected) {
  history_.add(reading, rejected);
  // Whoever computes with it must not see what was rejected; the record has it as it was given.
  Reading usable = reading;
  for (auto& value : usable.values)
    if (std::ranges::find(rejected, value.channel, &RejectedValue::channel) != rejected.end())
      value.value = kMissing;
  watchers_.publish(usable);
  arrived_.raise();
}

Awaitable<void> Recorder::next_reading_until(CellTime instant) {
  co_await sleep_unless(clock_, instant, arrived_);
}

double Recorder::period_s(std::size_t device) const {
  const auto& description = bench_.description(device);
  const bool is_idle = description.period_s <= 0 && is_read_by_runs(description.role());
  return is_idle ? kIdlePeriod_s : description.period_s;
}

Awaitable<void> Recorder::read_for_ever(std::size_t device) {
  const auto period = nanoseconds_from_s(period_s(device));
  const bool is_run_s = is_read_by_runs(bench_.description(device).role());
  const bool is_stored = bench_.description(device).period_s > 0;
  auto due = clock_.now().utc;
  auto environment_due = due;
  while (!ending_) {
    if (!is_run_s || !lent_) {
      // What fails is told by the bench, and tried again next period.
      if (auto reading = co_await bench_.read(device)) {
        observe(*reading);
        if (is_stored || stores_idle_) {
          writer_.add(std::move(*reading));
        } else if (const auto now = clock_.now().utc; now >= environment_due) {
          environment_due = now + nanoseconds_from_s(kEnvironmentPeriod_s);
          auto environment = environment_of(std::move(*reading));
          if (!environment.values.empty()) writer_.add(std::move(environment));
        }
      }
    }
    // A late reading does not make the next ones come in a burst: periods that have passed are left
    // out.
    const auto now = clock_.now().utc;
    due = due + period;
    if (due <= now) due = now + (period - (now - due) % period);
    if (!ending_) co_await lag_.sleep_unless(due, ended_);
  }
}

Awaitable<void> Recorder::flush_for_ever() {
  constexpr auto kEvery = std::chrono::seconds(5);
  constexpr auto kLongestWait =
      std::chrono::seconds(20);  // what a kill may cost: slow readings, no point
  std::int64_t before_gap = 0;
  bool dropping = false;
  std::string trouble;  // that the log has been told
  while (!ending_) {
    co_await sleep_unless(clock_, clock_.now().utc + kEvery, ended_);
    // Housekeeping of the store, here because it may take a while and a point must not wait for it.
    static_cast<void>(co_await writer_.call([](Store& store) { return store.idle(); }));
    // A run's points take the readings along: only what has waited longer than a point gets a
    // commit of its own.
    const auto since = writer_.gathered_since();
    if (!ending_ && (!since || clock_.now().utc - *since < kLongestWait)) continue;
    const auto stored = co_await writer_.flush();
    const std::string why = stored ? "" : stored.error().message;
    if (std::exchange(trouble, why) != why)
      spdlog::log(stored ? spdlog::level::info : spdlog::level::err, "{}",
                  stored ? "the record takes readings again" : "readings gather in memory: " + why);
    if (!dropping && writer_.dropped() > before_gap) {
      dropping = true;
      events_.record_own(
          "recorder.dropping",
          fmt::format("nothing can be written and {} readings wait: newer ones are dropped",
                      writer_.gathered()));
    } else if (dropping && stored) {
      dropping = false;
      events_.record_own("recorder.dropped",
                         fmt::format("{} readings were dropped while nothing could be written",
                                     writer_.dropped() - before_gap));
      before_gap = writer_.dropped();
    }
  }
}

}  // namespace driftwise::application
