#include "server/application/commissioning/rest_desk.h"

#include <fmt/format.h>

#include "server/application/plumbing/store_refusal.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

RestDesk::RestDesk(asio::any_io_executor executor, Clock& clock, Recorder& recorder,
                   StoreWriter& writer, EventLog& events, RunEngine& engine, RightToMove& right,
                   TaskGroup& tasks)
    : clock_(clock),
      recorder_(recorder),
      writer_(writer),
      events_(events),
      engine_(engine),
      right_(right),
      tasks_(tasks),
      ended_(executor),
      beginning_(std::move(executor)) {}

Awaitable<Result<void>> RestDesk::begin(Caller caller, RestLimits limits) {
  if (!(limits.length_nm_per_h > 0) || !(limits.temperature_k_per_h > 0) ||
      !(limits.window_s >= 300 && limits.window_s <= 6 * 3600))
    co_return fail(
        ErrorCode::invalid_argument, reasons::kBadLimits,
        fmt::format("found limits {:g} nm/h and {:g} K/h over {:g} s, expected both above "
                    "0 and a window of 5 min to 6 h",
                    limits.length_nm_per_h, limits.temperature_k_per_h, limits.window_s));
  if (engine_.busy())
    co_return fail(ErrorCode::failed_precondition, reasons::kRunUnderWay,
                   "a run is under way: a rest begins when it is over");
  if (right_.by_hand())
    co_return fail(ErrorCode::failed_precondition, reasons::kMoving,
                   "a movement by hand is under way: wait for its end");
  const auto lock = co_await beginning_.lock();
  // The one under way has an end on record before another one begins.
  if (under_way())
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await finish(fmt::format("{} began another one", caller.name)));
  Rest rest{0, clock_.now().utc, {}, caller.name, {}, limits};
  RestRecord record;
  record.begin = rest.begin;
  record.begun_by = rest.begun_by;
  record.length_nm_per_h = limits.length_nm_per_h;
  record.temperature_k_per_h = limits.temperature_k_per_h;
  record.window_s = limits.window_s;
  DRIFTWISE_CO_TRY(rest.id, co_await writer_.rests().begin_rest(std::move(record)));
  rest_ = std::move(rest);
  events_.record(
      caller, "rest.began",
      fmt::format("{} lets the cell rest: lengths and temperatures are recorded", caller.name));
  follow();
  co_return Result<void>{};
}

Awaitable<Result<void>> RestDesk::continue_unfinished() {
  DRIFTWISE_CO_TRY(auto newest, co_await writer_.rests().newest_rest());
  if (!newest) co_return Result<void>{};
  rest_ = Rest{
      newest->id,         newest->begin,
      newest->end,        newest->begun_by,
      newest->end_reason, {newest->length_nm_per_h, newest->temperature_k_per_h, newest->window_s}};
  if (!under_way()) co_return Result<void>{};
  if (engine_.busy()) co_return co_await finish("a run continues");
  events_.record_own("rest.continued",
                     fmt::format("the rest of {} goes on since {}: the daemon was away meanwhile",
                                 rest_->begun_by, to_iso8601(clock_.utc(rest_->begin))));
  follow();
  co_return Result<void>{};
}

Awaitable<Result<void>> RestDesk::end(Caller caller) {
  if (!under_way()) co_return fail(ErrorCode::not_found, reasons::kNoRest, "no rest is under way");
  co_return co_await finish("ended by " + caller.name);
}

// A rest that is under way goes on with the next start.
void RestDesk::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<Result<void>> RestDesk::finish(std::string why) {
  rest_->end = clock_.now().utc;
  rest_->end_reason = std::move(why);
  recorder_.store_idle(false);
  events_.record_own("rest.ended",
                     fmt::format("the rest of {} is over: {}", rest_->begun_by, rest_->end_reason));
  ended_.raise();
  const Rest over = *rest_;
  auto stored = co_await writer_.rests().end_rest(over.id, over.end, over.end_reason);
  if (!stored && may_be_stored_later(stored.error())) tasks_.spawn(store_end_later(over));
  co_return stored;
}

Awaitable<void> RestDesk::store_end_later(Rest over) {
  constexpr double kRetry_s = 5;
  for (bool stored = false; !stored && !ending_;) {
    const auto due = clock_.now().utc + nanoseconds_from_s(kRetry_s);
    while (!ending_ && clock_.now().utc < due) co_await sleep_unless(clock_, due, ended_);
    const auto again = co_await writer_.rests().end_rest(over.id, over.end, over.end_reason);
    stored = again || !may_be_stored_later(again.error());
  }
}

void RestDesk::follow() {
  recorder_.store_idle(true);
  if (!std::exchange(watching_, true)) tasks_.spawn(watch());
}

Awaitable<void> RestDesk::watch() {
  constexpr double kLook_s = 1;
  while (under_way() && !ending_) {
    if (engine_.busy()) {
      static_cast<void>(co_await finish("a run began"));
    } else if (right_.by_hand()) {
      static_cast<void>(co_await finish("an axis was moved by hand"));
    } else {
      co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(kLook_s), ended_);
    }
  }
  watching_ = false;
}

}  // namespace driftwise::application
