#include "server/application/runs/run_state_store.h"

#include <fmt/format.h>

#include <utility>

#include "server/application/runs/point_visit.h"
#include "server/application/runs/trajectory_walk.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr std::chrono::seconds kRetry{5};  // of cell time, until the database takes it

// Once per state: people see why a run that is over stays the run under way.
void tell_of_end(ActiveRun& run, const Error& refusal) {
  run.scope.bench.events.record_own(
      "run.trouble",
      fmt::format("the end of run {} is not on record yet: {}; it is written again every {} s, "
                  "and the run stays under way until then",
                  run.record.id.value, refusal.message, kRetry.count()),
      run.record.id);
  run.scope.phase("waiting until its end is on record");
}

}  // namespace

void pause_by_stop(RunRecord& record, const RunHold& stop) {
  record.state = RunState::paused;
  record.reason = stop.reason;
  record.hold = stop;
}

Awaitable<Result<void>> store_state(ActiveRun& run) {
  const auto& record = run.record;
  const auto asked = run.control.hold().kind;
  const bool of_person = asked == RunHold::Kind::pause || asked == RunHold::Kind::stop;
  if (run.unread && !of_person && !is_over(record.state)) co_return Result<void>{};
  RunChange change;
  change.state = record.state;
  change.reason = record.reason;
  if (record.started.utc_ns != 0) change.started = record.started;
  if (record.ended.utc_ns != 0) change.ended = record.ended;
  change.max_lag_s = record.max_lag_s;
  change.restarts = record.restarts;
  change.hold = record.hold;
  // Written after the stop and its pause, "running" would let a restart go on.
  if (const auto& hold = run.control.hold();
      hold.kind == RunHold::Kind::stop && !is_over(record.state)) {
    change.state = RunState::paused;
    change.reason = hold.reason;
    change.hold = hold;
  }
  if (!run.scope.bench.boot_id.empty()) change.boot_id = run.scope.bench.boot_id;
  for (bool told = false;;) {
    const auto stored = co_await run.scope.bench.writer.runs().change_run(record.id, change);
    run.state_unstored = !stored;
    if (stored || !is_over(record.state)) co_return Result<void>{};
    if (run.control.shutting_down()) co_return Result<void>{};
    if (!std::exchange(told, true)) tell_of_end(run, stored.error());
    co_await sleep_unless(run.scope.bench.clock, run.scope.bench.clock.now().utc + kRetry,
                          run.control.changed());
  }
}

Awaitable<Result<void>> wait_for_change(ActiveRun& run) {
  auto& changed = run.control.changed();
  if (!run.state_unstored) {
    co_await changed.wait();
    co_return Result<void>{};
  }
  auto& clock = run.scope.bench.clock;
  co_await sleep_unless(clock, clock.now().utc + kRetry, changed);
  if (run.control.held()) co_return co_await store_state(run);
  co_return Result<void>{};
}

void adopt_pause(ActiveRun& run) {
  const auto& asked = run.control.hold();
  auto& record = run.record;
  const bool is_halt = asked.kind == RunHold::Kind::pause || asked.kind == RunHold::Kind::stop ||
                       asked.kind == RunHold::Kind::trouble;
  if (record.state == RunState::paused || !is_halt) return;
  record.state = RunState::paused;
  record.hold = asked;
  record.reason = asked.reason;
}

Awaitable<Result<void>> record_interruption(ActiveRun& run) {
  const auto visit = next_visit(run.trajectory, run.record.place);
  if (!visit) co_return Result<void>{};
  AttemptRecord attempt;
  attempt.row = visit->row;
  attempt.number = ++run.attempts_of_row[visit->row];
  attempt.verdict = Verdict::interrupted;
  attempt.reason =
      "the daemon ended while this row was under way or about to be; instants are those of the "
      "restart";
  attempt.started = attempt.ended = run.scope.bench.clock.now();
  PointCommit commit{run.record.id, {std::move(attempt)}, {}, {}, {}, run.record.place};
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await commit_until_stored(run.scope, std::move(commit)));
  ++run.record.attempts;
  co_return Result<void>{};
}

DatumOpening continue_from(const CellDescription& description, std::string reason,
                           const RunBefore& before) {
  DatumOpening opening{std::move(reason), true, false, {}, {}};
  if (before.data.empty()) return opening;
  opening.before = before.data.back();
  for (const auto& zero : before.zeros) {
    if (zero.datum != opening.before->id) continue;
    add_closure(opening.closures, warming_since(description, *opening.before, zero.values),
                closure_nm(description, *opening.before, zero.values));
  }
  return opening;
}

}  // namespace driftwise::application
