#include "server/application/commissioning/commissioning_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/commissioning/device_checks.h"
#include "server/application/commissioning/recorded_series.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/stability/rest.h"

namespace driftwise::application {
namespace {

constexpr int kReadings = 8;  // of an instrument, for its spread
constexpr double kBlock_s = 60;

struct DeviceChannels {
  std::string device;
  std::vector<std::string> channels;
  std::vector<double> u_k;  // of thermometers, same order
};
using Wanted = std::vector<DeviceChannels>;

// Thermometers by the device that reads them; named empty: all.
Wanted thermometers_of(const CellDescription& cell, const std::vector<std::string>& named) {
  Wanted wanted;
  for (const auto& device : cell.devices) {
    DeviceChannels one{device.id, {}, {}};
    for (const auto& probe : device.probes()) {
      const auto name = probe.channel.name();
      if (!named.empty() && std::ranges::find(named, name) == named.end()) continue;
      one.channels.push_back(name);
      one.u_k.push_back(probe.u_k);
    }
    if (!one.channels.empty()) wanted.push_back(std::move(one));
  }
  return wanted;
}

Wanted rest_channels(const CellDescription& cell) {
  Wanted wanted;
  for (const auto& device : cell.devices) {
    DeviceChannels one{device.id, {}, {}};
    if (const auto* length = device.length()) one.channels.push_back(length->channel.name());
    for (const auto& probe : device.probes()) one.channels.push_back(probe.channel.name());
    if (!one.channels.empty()) wanted.push_back(std::move(one));
  }
  return wanted;
}

Result<std::vector<RecordedSeries>> read_wanted(Store& store, const Wanted& wanted, CellTime from,
                                                CellTime to) {
  std::vector<RecordedSeries> all;
  for (const auto& one : wanted) {
    DRIFTWISE_TRY(auto series, recorded_series(store, one.device, one.channels, from, to));
    std::ranges::move(series, std::back_inserter(all));
  }
  return all;
}

bool is_named_as_length(const std::string& channel) { return channel.ends_with("_mm"); }

void judge_channels(RestReport& report, const std::vector<RecordedSeries>& all) {
  bool all_warm = !all.empty();
  for (const auto& one : all) {
    const bool length = is_named_as_length(one.channel);
    const double scale = length ? 1e6 : 1;  // nm
    const double limit = length ? report.limits.length_nm_per_h : report.limits.temperature_k_per_h;
    auto samples = one.samples;
    for (double& value : samples.values) value = (value - one.samples.values.front()) * scale;
    const auto verdict = stability::rest_of(samples, report.limits.window_s, limit);
    RestChannel channel{
        one.channel, length ? "nm/h" : "K/h", length ? "nm" : "K", {}, {}, limit, verdict.change,
        {}};
    if (verdict.now) {
      channel.rate = verdict.now->rate_per_h;
      channel.u_rate = verdict.now->u_rate_per_h;
    }
    if (verdict.warm_at_s) channel.warm = report.begin + nanoseconds_from_s(*verdict.warm_at_s);
    if (!channel.warm)
      all_warm = false;
    else if (!report.warm || *report.warm < *channel.warm)
      report.warm = channel.warm;
    report.channels.push_back(std::move(channel));
  }
  if (!all_warm) report.warm.reset();
}

RestReport judged(RestReport& report, const std::vector<RecordedSeries>& all) {
  judge_channels(report, all);
  return report;
}

Result<ThermometerReport> compared(ThermometerReport& report, const Wanted& wanted,
                                   const std::vector<RecordedSeries>& all) {
  std::vector<stability::Thermometer> thermometers;
  std::size_t at = 0;
  for (const auto& one : wanted)
    for (const double u_k : one.u_k) {
      thermometers.push_back({all[at].channel, u_k, all[at].samples});
      report.scans =
          std::max(report.scans, static_cast<std::int64_t>(all[at].samples.values.size()));
      ++at;
    }
  report.comparison = stability::compare_thermometers(thermometers, kBlock_s);
  if (report.comparison.offsets.empty())
    return fail(ErrorCode::failed_precondition, reasons::kTooFewSamples,
                fmt::format("found {} minutes in which every thermometer has a value, expected at "
                            "least 8: let the cell rest, or name a longer time",
                            report.comparison.blocks));
  report.quiet = std::abs(report.comparison.common_drift_k_per_h) <= Commissioning::kQuiet_k_per_h;
  return report;
}

std::string rest_sentence(const RestReport& report, const Clock& clock) {
  if (report.warm)
    return fmt::format("warm since {}", to_iso8601(clock.utc(*report.warm)).substr(11, 5));
  std::string waiting;
  int count = 0;
  for (const auto& one : report.channels)
    if (!one.warm && ++count <= 3) waiting += (waiting.empty() ? "" : ", ") + one.channel;
  if (count > 3) waiting += fmt::format(" and {} more", count - 3);
  return report.channels.empty() ? "nothing was recorded yet"
                                 : fmt::format("not warm yet: {}", waiting);
}

}  // namespace

CommissioningService::CommissioningService(Workbench& bench, StoreReader& reader,
                                           StoreWriter& writer, const RunEngine& engine,
                                           RestDesk& rests, asio::any_io_executor worker)
    : bench_(bench),
      reader_(reader),
      writer_(writer),
      engine_(engine),
      rests_(rests),
      worker_(std::move(worker)) {}

Awaitable<CellCheck> CommissioningService::check(Caller caller) {
  CellCheck check;
  auto& devices = bench_.devices;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    Heard heard;
    const auto role = devices.description(i).role();
    const auto prepared = co_await devices.prepare(i);
    if (!prepared) heard.trouble = prepared.error();
    if (prepared && role == DeviceRole::motion) {
      const auto state = co_await devices.motion_state(i);
      if (state)
        heard.motion = *state;
      else
        heard.trouble = state.error();
    }
    // A run under way needs its instruments: one reading of each is enough beside it.
    const int readings = role == DeviceRole::motion                   ? 0
                         : measures_pose(role) && !engine_.measures() ? kReadings
                                                                      : 1;
    for (int n = 0; n < readings && !heard.trouble; ++n) {
      auto reading = co_await devices.read(i);
      if (reading)
        heard.readings.push_back(std::move(*reading));
      else
        heard.trouble = reading.error();
    }
    heard.status = devices.status()[i];
    const auto now = bench_.clock.now().utc;
    for (auto& item : check_device(bench_.description, heard, now, bench_.clock.utc(now).ns,
                                   bench_.clock.speed()))
      check.items.push_back(std::move(item));
  }
  check.at = bench_.clock.now().utc;
  const auto bad = std::ranges::count(check.items, Finding::bad, &CheckItem::finding);
  const auto warned = std::ranges::count(check.items, Finding::warning, &CheckItem::finding);
  bench_.events.record(caller, "cell.checked",
                       fmt::format("{} checked the cell: {} of {} answers are bad, {} ask for a "
                                   "look",
                                   caller.name, bad, check.items.size(), warned));
  co_return check;
}

Awaitable<Result<ThermometerReport>> CommissioningService::compare_thermometers(
    CellTime from, CellTime to, std::vector<std::string> channels) {
  if (from.utc_ns >= to.utc_ns)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadRange,
                   "from is not before to: expected a stretch of the record");
  const auto wanted = thermometers_of(bench_.description, channels);
  std::size_t count = 0;
  for (const auto& one : wanted) count += one.channels.size();
  if (count < 2 || (!channels.empty() && count < channels.size()))
    co_return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                   fmt::format("found {} thermometers of this cell among those named, expected at "
                               "least 2 probes such as t07_degC, and no others",
                               count));
  static_cast<void>(co_await writer_.flush());
  DRIFTWISE_CO_TRY(auto all, co_await reader_.call(read_wanted, wanted, from, to));
  ThermometerReport report;
  report.from = from;
  report.to = to;
  co_return co_await run_on(worker_, compared, report, wanted, std::move(all));
}

Awaitable<Result<void>> CommissioningService::begin_rest(Caller caller, RestLimits limits) {
  return rests_.begin(std::move(caller), limits);
}

Awaitable<Result<void>> CommissioningService::end_rest(Caller caller) {
  return rests_.end(std::move(caller));
}

Awaitable<Result<RestReport>> CommissioningService::rest() {
  const auto& last = rests_.last();
  if (!last)
    co_return fail(ErrorCode::not_found, reasons::kNoRest, "this cell has had no rest: begin one");
  RestReport report{last->begin, last->end, last->begun_by, last->end_reason, last->limits, {},
                    {},          {}};
  const CellTime from = report.begin;
  const CellTime to = report.end.utc_ns != 0 ? report.end : bench_.clock.now().utc;
  const auto wanted = rest_channels(bench_.description);
  static_cast<void>(co_await writer_.flush());
  DRIFTWISE_CO_TRY(auto all, co_await reader_.call(read_wanted, wanted, from, to));
  std::erase_if(all, [](const RecordedSeries& one) { return one.samples.values.empty(); });
  report = co_await run_on(worker_, judged, report, std::move(all));
  report.sentence = rest_sentence(report, bench_.clock);
  co_return report;
}

std::vector<CertificateState> CommissioningService::certificates() const {
  std::vector<CertificateState> out;
  const auto utc = bench_.clock.utc(bench_.clock.now().utc);
  for (const auto& one : bench_.description.certificates)
    out.push_back({one, one.days_left(utc.ns)});
  return out;
}

}  // namespace driftwise::application
