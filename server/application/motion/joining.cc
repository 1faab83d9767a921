#include "server/application/motion/joining.h"

#include "server/core/try.h"

namespace driftwise::application {

Result<std::vector<ChannelValue>> join_slow_channels(const CellDescription& description,
                                                     const ChannelHistory& history,
                                                     CellTime instant, double max_age_s) {
  std::vector<ChannelValue> values;
  for (const auto& channel : description.temperature_channels()) {
    DRIFTWISE_TRY(const auto joined, history.at(channel.name(), instant, max_age_s));
    values.push_back({channel.name(), joined.value});
  }
  for (const auto& latest : history.latest()) {
    const auto* device = description.find_device(latest.device);
    if (!device || !joins_when_fresh(device->role())) continue;
    if (const auto joined = history.at(latest.channel, instant, device->max_age_s))
      values.push_back({latest.channel, joined->value});
  }
  return values;
}

Awaitable<Result<std::vector<ChannelValue>>> join_when_scanned(RunScope& scope, CellTime instant) {
  const double max_age_s = scope.rules.max_temperature_age_s;
  const auto limit = instant + nanoseconds_from_s(max_age_s);
  while (true) {
    auto joined = join_slow_channels(scope.bench.description, scope.bench.recorder.history(),
                                     instant, max_age_s);
    if (joined || scope.bench.clock.now().utc > limit) co_return joined;
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
    scope.phase("waiting for the next temperature scan");
    co_await scope.bench.recorder.next_reading_until(limit + std::chrono::milliseconds(1));
  }
}

}  // namespace driftwise::application
