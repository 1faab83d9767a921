#include "server/application/runs/recovery.h"

#include <algorithm>

#include "server/application/motion/joining.h"
#include "server/application/motion/sampling.h"

namespace driftwise::application {
namespace {

Awaitable<Result<Recovery>> look_once(RunScope& scope) {
  Recovery found;
  auto& devices = scope.bench.devices;
  if (auto ok = co_await devices.prepare_for_run(); !ok) co_return tl::unexpected(ok.error());
  const auto state = co_await devices.motion_state();
  if (!state) co_return tl::unexpected(state.error());
  found.reference_lost = !state->referenced;
  for (std::size_t i = 0; i < devices.collimators(); ++i)
    if (const auto reading = co_await devices.read_collimator(i); !reading)
      co_return tl::unexpected(reading.error());
  for (std::size_t i = 0; i < devices.interferometers(); ++i) {
    const auto reading = co_await devices.read_interferometer(i);
    if (reading) continue;
    if (reading.error().reason != "BEAM_LOST") co_return tl::unexpected(reading.error());
    found.beam_lost = true;
  }
  // Before the axes move again: what they say must be possible where they are.
  if (!found.beam_lost && !found.reference_lost)
    if (auto good = co_await look_at_pose(scope); !good) co_return tl::unexpected(good.error());
  const auto temperatures =
      join_slow_channels(scope.bench.description, scope.bench.recorder.history(),
                         scope.bench.clock.now().utc, scope.rules.max_temperature_age_s);
  if (!temperatures) co_return tl::unexpected(temperatures.error());
  co_return found;
}

}  // namespace

Awaitable<Result<Recovery>> wait_for_devices(RunScope& scope) {
  constexpr double kFirst_s = 1, kLongest_s = 10;
  double pause_s = kFirst_s;
  while (true) {
    if (auto ok = co_await scope.sleep_s(pause_s); !ok) co_return tl::unexpected(ok.error());
    if (auto found = co_await look_once(scope)) co_return found;
    scope.phase("waiting for a device");
    pause_s = std::min(kLongest_s, pause_s * 2);
  }
}

}  // namespace driftwise::application
