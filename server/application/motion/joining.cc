#include "server/application/motion/joining.h"

#include <algorithm>

#include "server/core/try.h"

namespace driftwise::application {
namespace {

// A force belongs to the place where it was measured: one of the way there is not taken.
std::optional<CellTime> counts_since(const DeviceDescription& device,
                                     std::optional<CellTime> at_rest) {
  if (device.role() != DeviceRole::force) return ChannelHistory::kAnyTime;
  return at_rest;
}

// Devices whose last reading began before the axes stood still, or is too old: asked now, once. One
// that does not answer leaves the point without its force.
Awaitable<Result<void>> read_forces_at_rest(RunScope& scope, CellTime instant) {
  auto& bench = scope.bench;
  if (!scope.at_rest) co_return Result<void>{};
  const auto lost = bench.devices.lost();
  for (const auto device : bench.devices.with_role(DeviceRole::force)) {
    const auto& description = bench.devices.description(device);
    const auto since =
        std::max(*scope.at_rest, instant - nanoseconds_from_s(description.max_age_s));
    if (bench.recorder.history().has_reading_since(description.id, since) ||
        std::ranges::find(lost, description.id) != lost.end())
      continue;
    scope.phase("reading the forces");
    if (auto reading = co_await bench.devices.read(device)) {
      bench.recorder.observe(*reading);
      bench.writer.add(std::move(*reading));
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
  }
  co_return Result<void>{};
}

}  // namespace

Result<std::vector<ChannelValue>> join_slow_channels(const CellDescription& description,
                                                     const ChannelHistory& history,
                                                     CellTime instant, double max_age_s,
                                                     std::optional<CellTime> at_rest) {
  std::vector<ChannelValue> values;
  for (const auto& channel : description.temperature_channels()) {
    DRIFTWISE_TRY(const auto joined, history.at(channel.name(), instant, max_age_s));
    values.push_back({channel.name(), joined.value});
  }
  for (const auto& latest : history.latest()) {
    const auto* device = description.find_device(latest.device);
    if (!device || !joins_when_fresh(device->role())) continue;
    const auto since = counts_since(*device, at_rest);
    if (!since) continue;
    if (const auto joined = history.at(latest.channel, instant, device->max_age_s, *since))
      values.push_back({latest.channel, joined->value});
  }
  return values;
}

Awaitable<Result<std::vector<ChannelValue>>> join_when_scanned(RunScope& scope, CellTime instant) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await read_forces_at_rest(scope, instant));
  const double max_age_s = scope.rules.max_temperature_age_s;
  const auto limit = instant + nanoseconds_from_s(max_age_s);
  while (true) {
    auto joined = join_slow_channels(scope.bench.description, scope.bench.recorder.history(),
                                     instant, max_age_s, scope.at_rest);
    if (joined || scope.bench.clock.now().utc > limit) co_return joined;
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
    scope.phase("waiting for the next temperature scan");
    co_await scope.bench.recorder.next_reading_until(limit + std::chrono::milliseconds(1));
  }
}

}  // namespace driftwise::application
