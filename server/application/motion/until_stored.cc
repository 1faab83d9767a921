#include "server/application/motion/until_stored.h"

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr double kDiskRetry_s = 5;  // of cell time

}  // namespace

Awaitable<Result<void>> DiskWait::next_try(Error refusal) {
  if (scope_.control.shutting_down()) co_return scope_.control.check();
  no_room_ = refusal.reason == reasons::kDiskFull;
  if (!std::exchange(waiting_, true)) {
    // Written when there is room again: the record must say why the run stood.
    scope_.bench.events.record_own("run.trouble", refusal.message, scope_.run);
    auto entering = scope_.enter_waiting(refusal.message);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(entering));
  }
  scope_.phase(no_room_ ? "waiting for room on the disk" : "waiting for the database");
  if (ends_ == EndsWait::whatever_ends_a_step) co_return co_await scope_.sleep_s(kDiskRetry_s);
  auto& clock = scope_.bench.clock;
  const auto due = clock.now().utc + nanoseconds_from_s(kDiskRetry_s);
  while (clock.now().utc < due && !scope_.control.shutting_down())
    co_await sleep_unless(clock, due, scope_.control.changed());
  if (scope_.control.shutting_down()) co_return scope_.control.check();
  co_return Result<void>{};
}

Awaitable<Result<void>> DiskWait::over() {
  if (!waiting_) co_return Result<void>{};
  scope_.bench.events.record_own(
      "run.resumed",
      no_room_ ? "there is room on the disk again" : "the database takes points again", scope_.run);
  co_return co_await scope_.leave_waiting();
}

}  // namespace driftwise::application
