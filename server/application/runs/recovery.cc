#include "server/application/runs/recovery.h"

#include <algorithm>

#include "server/application/motion/joining.h"
#include "server/application/motion/sampling.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

Awaitable<Result<Recovery>> look_once(RunScope& scope) {
  Recovery found;
  auto& devices = scope.bench.devices;
  // Whatever else is away: axes that lose their current, or are moved, meanwhile are an alarm.
  static_cast<void>(co_await devices.motion_state());
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await devices.prepare_for_run());
  DRIFTWISE_CO_TRY(const auto state, co_await devices.motion_state());
  found.reference_lost = !state.referenced;
  found.servo_off = !state.servo_on;
  for (const auto device : devices.with_role(DeviceRole::angle))
    if (const auto reading = co_await devices.read(device);
        !reading && !(reading.error().reason == reasons::kNoSpot && devices.may_be_lost(device)))
      co_return tl::unexpected(reading.error());
  for (const auto device : devices.with_role(DeviceRole::length)) {
    const auto reading = co_await devices.read(device);
    if (reading) continue;
    if (reading.error().reason != reasons::kBeamLost) co_return tl::unexpected(reading.error());
    found.beam_lost = true;
  }
  // Before the axes move again: what they say must be possible where they are.
  if (!found.beam_lost && !found.reference_lost && !found.servo_off)
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await look_at_pose(scope));
  DRIFTWISE_CO_RETURN_IF_ERROR(
      join_slow_channels(scope.bench.description, scope.bench.recorder.history(),
                         scope.bench.clock.now().utc, scope.rules.max_temperature_age_s));
  co_return found;
}

}  // namespace

Awaitable<Result<Recovery>> wait_for_devices(RunScope& scope) {
  constexpr double kFirst_s = 1, kLongest_s = 10;
  double pause_s = kFirst_s;
  for (bool waited = false;; waited = true) {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await scope.sleep_s(pause_s));
    if (auto found = co_await look_once(scope)) {
      found->waited = waited;
      co_return found;
    }
    scope.phase("waiting for a device");
    pause_s = std::min(kLongest_s, pause_s * 2);
  }
}

}  // namespace driftwise::application
