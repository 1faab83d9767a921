#include "server/application/motion/loading.h"

#include <fmt/format.h>

#include <cmath>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr double kSameForce_n = 5e-4;  // 0.05 g: what the weights are known to
constexpr double kNearestForce_n =
    0.02;  // an actuator lays on the nearest of its own weights, and says which
constexpr double kLoadPoll_s = 0.5;
constexpr double kSlowest_s = 600;  // of moving weights; then the pan is caught somewhere

}  // namespace

bool same_force(double a_n, double b_n) { return std::abs(a_n - b_n) <= kSameForce_n; }

std::string hang_sentence(double force_n, const LoadDescription& load) {
  if (same_force(force_n, 0)) return "take every weight off: 0 N";
  return fmt::format("hang {:.6g} N ({:.0f} g)", force_n, 1000 * force_n / load.gravity_m_s2);
}

Result<void> check_force(const CellDescription& description, double force_n) {
  if (!description.load)
    return fail(ErrorCode::failed_precondition, reasons::kNoLoad,
                fmt::format("force_N = {:g} was asked for, the cell knows no force: give it a "
                            "[load] section with max_n",
                            force_n));
  if (force_n >= 0 && force_n <= description.load->max_n) return {};
  return fail(ErrorCode::out_of_range, reasons::kForceLimit,
              fmt::format("force_N = {:g} was asked for, the limit is 0 to {:g} N: stay inside, or "
                          "change [load] max_n in the cell file",
                          force_n, description.load->max_n));
}

Awaitable<Result<void>> Loading::look(DeviceBench& devices) {
  if (!devices.has(DeviceRole::load)) co_return Result<void>{};
  DRIFTWISE_CO_TRY(const auto state, co_await devices.load_state());
  if (state.resting) know(state.force_n);
  co_return Result<void>{};
}

Awaitable<Result<void>> Loading::bring_to(RunScope& scope, double force_n) {
  if (auto ok = check_force(scope.bench.description, force_n); !ok) co_return ok;
  if (auto ok = co_await look(scope.bench.devices); !ok) co_return ok;
  const bool has_actuator = scope.bench.devices.has(DeviceRole::load);
  const double same_n = has_actuator ? kNearestForce_n : kSameForce_n;
  if (known_n_ && std::abs(*known_n_ - force_n) <= same_n) co_return Result<void>{};
  auto changed = has_actuator ? by_actuator(scope, force_n) : by_person(scope, force_n);
  if (auto ok = co_await std::move(changed); !ok) co_return ok;
  const auto how = has_actuator ? "by the actuator" : "by hand";
  scope.bench.events.record_own(
      "load.changed", fmt::format("{:.6g} N act now, {}", known_n_.value_or(force_n), how),
      scope.run);
  co_return Result<void>{};
}

Awaitable<Result<void>> Loading::by_actuator(RunScope& scope, double force_n) {
  scope.phase(kChangingTheForce);
  auto& devices = scope.bench.devices;
  if (auto ok = co_await devices.set_load(force_n); !ok) co_return ok;
  const auto limit = scope.bench.clock.now().utc + nanoseconds_from_s(kSlowest_s);
  while (true) {
    DRIFTWISE_CO_TRY(const auto state, co_await devices.load_state());
    if (state.resting && std::abs(state.force_n - force_n) <= kNearestForce_n) {
      know(state.force_n);
      // It may be a while until the actuator is read again.
      if (const auto force = scope.bench.description.force_channel())
        scope.bench.recorder.observe(
            JudgedReading{Reading{.device = devices.load_description().id,
                                  .start = state.at,
                                  .end = state.at,
                                  .values = {{force->name(), state.force_n}}},
                          {}});
      co_return Result<void>{};
    }
    if (scope.bench.clock.now().utc > limit)
      co_return fail(
          ErrorCode::deadline_exceeded, reasons::kLoadSlow,
          fmt::format("{} was asked for {:g} N and is at {:g} N after {:g} s: look at "
                      "its pan and pulleys",
                      devices.load_description().id, force_n, state.force_n, kSlowest_s));
    if (auto ok = co_await scope.sleep_s(kLoadPoll_s); !ok) co_return ok;
  }
}

Awaitable<Result<void>> Loading::by_person(RunScope& scope, double force_n) {
  scope.control.want_force(force_n);
  auto why = fmt::format("{}, then: driftwise run confirm {} --force {:.6g}",
                         hang_sentence(force_n, *scope.bench.description.load),
                         scope.run.value_or(RunId{}).value, force_n);
  auto waiting = scope.enter_waiting(std::move(why));
  if (auto ok = co_await std::move(waiting); !ok) co_return ok;
  scope.phase("waiting for a person");
  while (scope.control.wanted_force()) {
    if (auto ok = scope.control.check(); !ok) {
      scope.control.want_no_force();
      co_return ok;
    }
    co_await scope.control.changed().wait();
  }
  if (auto ok = scope.control.check(); !ok) co_return ok;
  know(force_n);
  co_return co_await scope.leave_waiting();
}

}  // namespace driftwise::application
