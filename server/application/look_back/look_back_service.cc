#include "server/application/look_back/look_back_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/commissioning/recorded_series.h"
#include "server/application/look_back/compared_run.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/stability/stretch.h"

namespace driftwise::application {
namespace {

constexpr std::size_t kFewestSamples = 16;

std::string where_more_is(const Channel& channel) {
  const bool in_runs = channel.unit == "mm" || channel.unit == "arcsec";
  return in_runs
             ? "lengths and rotations are recorded in runs and while the cell rests ('driftwise "
               "align rest'): name a time with one of them"
             : "name a longer time (--hours), or wait until its device was read so often "
               "(period_s in the cell file)";
}

// asked_for: the channel and the time, for the refusal.
Result<Stability> analysed(Stability& out, const std::vector<RecordedSeries>& recorded,
                           const std::string& asked_for, const Channel& channel) {
  const auto& samples = recorded.front().samples;
  const auto stretch = stability::longest_stretch(samples);
  out.all = static_cast<std::int64_t>(samples.values.size());
  if (stretch.size() < kFewestSamples)
    return fail(
        ErrorCode::failed_precondition, reasons::kTooFewSamples,
        fmt::format("{}: found {} values without a gap ({} in all), expected at least {}; {}",
                    asked_for, stretch.size(), out.all, kFewestSamples, where_more_is(channel)));
  const double scale = out.unit == "nm" ? 1e6 : out.unit == "mK" ? 1e3 : 1;
  std::vector<double> values;
  const double first = samples.values[stretch.begin];
  for (std::size_t i = stretch.begin; i < stretch.end; ++i)
    values.push_back((samples.values[i] - first) * scale);
  const CellTime asked = out.from;
  out.from = asked + nanoseconds_from_s(samples.time_s[stretch.begin]);
  out.to = asked + nanoseconds_from_s(samples.time_s[stretch.end - 1]);
  out.used = static_cast<std::int64_t>(values.size());
  out.interval_s = stretch.interval_s;
  out.allan = stability::allan_deviation(values, out.interval_s, stability::octaves(values.size()));
  out.spectrum = stability::power_spectrum(values, out.interval_s);
  out.sentence = stability::noise_sentence(out.allan);
  return out;
}

Result<std::vector<RecordedSeries>> read_channel(Store& store, const std::string& device,
                                                 const std::string& channel, CellTime from,
                                                 CellTime to) {
  return recorded_series(store, device, {channel}, from, to);
}

ComparedRun with_measured(ComparedRun& run, const Dataset& data,
                          const std::vector<DatumRecord>& datums) {
  add_measured(data, datums, run);
  return run;
}

std::string shown_unit(const std::string& unit) {
  if (unit == "mm") return "nm";
  if (unit == "degC") return "mK";
  return unit;
}

}  // namespace

LookBackService::LookBackService(Workbench& bench, StoreReader& reader, Datasets& datasets,
                                 Models& models, asio::any_io_executor worker)
    : bench_(bench),
      reader_(reader),
      datasets_(datasets),
      models_(models),
      worker_(std::move(worker)) {}

std::string LookBackService::device_of(const std::string& channel) const {
  for (const auto& device : bench_.description.devices)
    if (std::ranges::find(device.channels, channel, &Channel::name) != device.channels.end())
      return device.id;
  // Quantities that a driver gives beside those of the cell file.
  const auto* latest = bench_.recorder.history().latest(channel);
  return latest != nullptr ? latest->device : std::string();
}

std::string LookBackService::with_unit(std::string channel) const {
  for (const auto& device : bench_.description.devices)
    for (const auto& given : device.channels)
      if (given.symbol == channel) return given.name();
  return channel;
}

Awaitable<Result<Stability>> LookBackService::stability_of(std::string channel, CellTime from,
                                                           CellTime to) {
  if (from.utc_ns >= to.utc_ns)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadRange,
                   "from is not before to: expected a stretch of the record");
  channel = with_unit(std::move(channel));
  DRIFTWISE_CO_TRY(const auto parsed, parse_robot_channel(channel));
  const auto device = device_of(channel);
  if (bench_.description.find_device(device) == nullptr)
    co_return fail(ErrorCode::not_found, reasons::kNoSuchChannel,
                   fmt::format("no device of this cell gives '{}': 'driftwise readings' lists the "
                               "channels",
                               channel));
  Stability out;
  out.channel = channel;
  out.unit = shown_unit(parsed.unit);
  out.from = from;
  out.to = to;
  static_cast<void>(co_await bench_.writer.flush());
  DRIFTWISE_CO_TRY(auto recorded, co_await reader_.call(read_channel, device, channel, from, to));
  const std::string asked_for =
      fmt::format("{} from {} to {}", channel, to_iso8601(bench_.clock.utc(from)),
                  to_iso8601(bench_.clock.utc(to)));
  co_return co_await run_on(worker_, analysed, out, std::move(recorded), asked_for, parsed);
}

Awaitable<Result<std::vector<ComparedRun>>> LookBackService::compare(std::vector<RunId> runs,
                                                                     std::optional<ModelId> model) {
  if (runs.empty() || runs.size() > kMostRuns)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadCount,
                   fmt::format("found {} runs, expected 1 to {}", runs.size(), kMostRuns));
  std::vector<ComparedRun> out;
  for (const RunId id : runs) {
    ComparedRun one;
    DRIFTWISE_CO_TRY(one.run, co_await reader_.runs().run(id));
    std::vector<RunId> only{id};
    std::string no_text;
    auto loading = datasets_.load(only, no_text);
    DRIFTWISE_CO_TRY(auto data, co_await std::move(loading));
    DRIFTWISE_CO_TRY(auto datums, co_await reader_.points().data(id));
    one =
        co_await run_on(worker_, with_measured, std::move(one), std::move(data), std::move(datums));
    if (model) {
      auto asking = models_.residuals(*model, only, no_text);
      const auto residuals = co_await std::move(asking);
      if (residuals)
        add_residuals(*residuals, one);
      else if (residuals.error().code == ErrorCode::not_found)
        co_return tl::unexpected(residuals.error());
      else
        one.residual_trouble = residuals.error().message;
    }
    out.push_back(std::move(one));
  }
  co_return out;
}

Awaitable<Result<TimeNoteRecord>> LookBackService::add_note(Caller caller, TimeNoteRecord note) {
  if (note.text.find_first_not_of(" \t\n") == std::string::npos)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadSubject,
                   "text: found nothing, expected what there is to say");
  note.channel = with_unit(std::move(note.channel));
  if (!note.channel.empty() && device_of(note.channel).empty())
    co_return fail(
        ErrorCode::invalid_argument, reasons::kBadSubject,
        fmt::format("channel: found '{}', which no device of this cell gives", note.channel));
  note.at = bench_.clock.now();
  note.who = caller.name;
  note.from = caller.peer;
  auto storing = bench_.writer.remarks().add_time_note(note);
  DRIFTWISE_CO_TRY(auto stored, co_await std::move(storing));
  bench_.events.record(
      caller, "note.pinned",
      fmt::format("{} at {}{}: {}", stored.who, to_iso8601(bench_.clock.utc(stored.about)),
                  stored.channel.empty() ? "" : " on " + stored.channel, stored.text),
      {}, {fmt::format("time note {}", stored.id), "", stored.text});
  co_return stored;
}

}  // namespace driftwise::application
