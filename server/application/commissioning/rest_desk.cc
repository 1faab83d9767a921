#include "server/application/commissioning/rest_desk.h"

#include <fmt/format.h>

#include "server/core/reasons.h"

namespace driftwise::application {

RestDesk::RestDesk(asio::any_io_executor executor, Clock& clock, Recorder& recorder,
                   EventLog& events, RunEngine& engine, RightToMove& right, TaskGroup& tasks)
    : clock_(clock),
      recorder_(recorder),
      events_(events),
      engine_(engine),
      right_(right),
      tasks_(tasks),
      ended_(std::move(executor)) {}

Result<void> RestDesk::begin(const Caller& caller, RestLimits limits) {
  if (!(limits.length_nm_per_h > 0) || !(limits.temperature_k_per_h > 0) ||
      !(limits.window_s >= 300 && limits.window_s <= 6 * 3600))
    return fail(ErrorCode::invalid_argument, reasons::kBadLimits,
                fmt::format("found limits {:g} nm/h and {:g} K/h over {:g} s, expected both above "
                            "0 and a window of 5 min to 6 h",
                            limits.length_nm_per_h, limits.temperature_k_per_h, limits.window_s));
  if (engine_.busy())
    return fail(ErrorCode::failed_precondition, reasons::kRunUnderWay,
                "a run is under way: a rest begins when it is over");
  if (right_.by_hand())
    return fail(ErrorCode::failed_precondition, reasons::kMoving,
                "a movement by hand is under way: wait for its end");
  const bool is_under_way = rest_ && rest_->end.utc_ns == 0;
  rest_ = Rest{clock_.now().utc, {}, caller.name, {}, limits};
  events_.record(
      caller, "rest.began",
      fmt::format("{} lets the cell rest: lengths and temperatures are recorded", caller.name));
  if (is_under_way) return {};  // begun anew: the same task watches it
  recorder_.store_idle(true);
  tasks_.spawn(watch());
  return {};
}

Result<void> RestDesk::end(const Caller& caller) {
  if (!rest_ || rest_->end.utc_ns != 0)
    return fail(ErrorCode::not_found, reasons::kNoRest, "no rest is under way");
  finish("ended by " + caller.name);
  return {};
}

void RestDesk::shut_down() {
  if (rest_ && rest_->end.utc_ns == 0) finish("the daemon ended");
}

void RestDesk::finish(std::string why) {
  rest_->end = clock_.now().utc;
  rest_->end_reason = std::move(why);
  recorder_.store_idle(false);
  events_.record_own("rest.ended",
                     fmt::format("the rest of {} is over: {}", rest_->begun_by, rest_->end_reason));
  ended_.raise();
}

Awaitable<void> RestDesk::watch() {
  constexpr double kLook_s = 1;
  while (rest_->end.utc_ns == 0) {
    if (engine_.busy()) {
      finish("a run began");
    } else if (right_.by_hand()) {
      finish("an axis was moved by hand");
    } else {
      co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(kLook_s), ended_);
    }
  }
}

}  // namespace driftwise::application
