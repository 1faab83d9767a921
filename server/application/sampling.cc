#include "server/application/sampling.h"

#include <algorithm>
#include <map>

#include "server/application/point_decision.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

Reading readback(const CellDescription& description, const DeviceDescription& controller,
                 const MotionState& state, std::int64_t sequence) {
  Reading reading{controller.id, state.at, state.at, sequence, {}};
  const auto channels = description.motor_channels();
  for (std::size_t i = 0; i < std::min(channels.size(), state.q_mm.size()); ++i)
    reading.values.push_back({channels[i].name(), state.q_mm[i]});
  return reading;
}

// About the first value: means of mm must keep their nanometres.
double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v - values.front();
  return values.front() + sum / static_cast<double>(values.size());
}

void summarise(const CellDescription& description, Sampling& sampling) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> values;
  for (const auto& reading : sampling.readings)
    for (const auto& value : reading.values) {
      if (is_missing(value.value)) continue;
      auto& list = values[value.channel];
      if (list.empty()) order.push_back(value.channel);
      list.push_back(value.value);
    }
  for (const auto& channel : description.motor_channels())
    sampling.q_mm.push_back(mean(values[channel.name()]));
  for (const auto& length : description.length_channels()) {
    const auto& list = values[length.name()];
    const double spread = list.empty() ? kMissing : spread_nm(list);
    sampling.spreads_nm.push_back({length.symbol + "_std_nm", spread});
    if (is_missing(sampling.spread_nm) || spread > sampling.spread_nm) sampling.spread_nm = spread;
  }
  for (const auto& name : order) {
    const bool is_motor = is_motor_symbol(name.substr(0, name.rfind('_')));
    const bool is_spread =
        name.ends_with("_std_nm");  // of the device's own samples: stays in its reading
    if (!is_motor && !is_spread) sampling.raw.push_back({name, mean(values[name])});
  }
}

// One round of all instruments as a reading of the pose, for those who watch; nothing is stored of
// it.
void show_pose(RunScope& scope, const std::vector<Reading>& round, std::int64_t number) {
  if (scope.bench.pose.is_identity() || round.empty()) return;
  std::vector<ChannelValue> raw;
  Reading shown{"pose", round.front().start, round.front().end, number, {}};
  for (const auto& reading : round) {
    shown.start = std::min(shown.start, reading.start);
    shown.end = std::max(shown.end, reading.end);
    for (const auto& value : reading.values)
      if (const auto channel = parse_channel(value.channel);
          channel && is_pose_symbol(channel->symbol))
        raw.push_back(value);
  }
  for (auto& value : scope.bench.pose.pose(raw))
    if (const auto channel = parse_channel(value.channel);
        channel && is_pose_symbol(channel->symbol))
      shown.values.push_back(std::move(value));
  scope.bench.recorder.show(shown);
}

}  // namespace

Awaitable<Result<Sampling>> take_readings(RunScope& scope, int count) {
  scope.phase("reading");
  auto& devices = scope.bench.devices;
  Sampling sampling;
  std::optional<CellTime> first, last;
  for (int k = 0; k <= count; ++k) {
    const auto state = co_await devices.motion_state();
    if (!state) co_return tl::unexpected(state.error());
    sampling.readings.push_back(
        readback(scope.bench.description, devices.controller_description(), *state, k));
    // The last look at the axes decides too: they may have moved during the last reading.
    if (auto ok = scope.control.check(); !ok) co_return tl::unexpected(ok.error());
    if (k == count) break;
    auto round = co_await devices.read_pose_instruments();
    if (!round) co_return tl::unexpected(round.error());
    for (const auto& reading : *round) {
      if (!first || reading.middle() < *first) first = reading.middle();
      if (!last || reading.middle() > *last) last = reading.middle();
      scope.bench.recorder.observe(reading);
    }
    show_pose(scope, *round, k);
    for (auto& reading : *round) sampling.readings.push_back(std::move(reading));
    if (auto ok = scope.control.check(); !ok) co_return tl::unexpected(ok.error());
  }
  summarise(scope.bench.description, sampling);
  sampling.means = scope.bench.pose.pose(sampling.raw);
  const auto now = scope.bench.clock.now();
  const auto middle =
      first ? CellTime{first->utc_ns + (last->utc_ns - first->utc_ns) / 2} : now.utc;
  sampling.measured = {middle, now.monotonic_ns - (now.utc - middle).count()};
  co_return sampling;
}

}  // namespace driftwise::application
