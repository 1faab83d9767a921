// The run that was under way when the daemon ended.

#include <algorithm>

#include "server/application/plumbing/run_on.h"
#include "server/application/runs/run_state_store.h"
#include "server/application/runs/runs_service.h"
#include "server/application/trajectories/duration_book.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::application {

// Tried again for a while: of a run that is not found nobody can ask for anything, and the queue
// waits for its end.
Awaitable<Result<std::optional<RunRecord>>> RunsService::find_unfinished() {
  constexpr int kTries = 10;
  for (int tried = 1;; ++tried) {
    auto unfinished = co_await reader_.call([](Store& store) -> Result<std::optional<RunRecord>> {
      auto run = store.runs().unfinished_run();
      if (!run || *run) return run;
      DRIFTWISE_TRY(auto newest, store.runs().runs(1, 0));  // created, and killed before it began
      if (newest.empty() || newest.front().state != RunState::queued) return std::nullopt;
      DRIFTWISE_TRY(auto queued, store.runs().run(newest.front().id));  // with its trajectory
      return queued;
    });
    if (unfinished || tried == kTries || engine_.shutting_down()) co_return unfinished;
    co_await clock_.sleep_for(std::chrono::seconds(1));
  }
}

Awaitable<Result<RunBasis>> RunsService::read_basis(RunRecord record) {
  RunBasis basis;
  DRIFTWISE_CO_TRY(basis.trajectory,
                   co_await run_on(background_, formats::read_trajectory_csv,
                                   record.trajectory_text, record.trajectory_name));
  DRIFTWISE_CO_TRY(basis.plan, read_run_plan(record.rules_json));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await follow_for(basis.plan));
  if (record.started.utc_ns != 0) {  // else it has not begun, paused by a stop or not
    DRIFTWISE_CO_TRY(auto found, co_await what_was_before(record));
    auto meter = co_await reader_.call(recorded_meter, record, PlanLength(basis.trajectory),
                                       planned_visit_s(basis.plan.rules));
    if (meter) found.meter = std::move(*meter);
    basis.before = std::move(found);
  }
  // Measured on under another cell file only when a person has seen the difference.
  if (configuration_.question_for(record).empty()) {
    const UsedConfiguration used{description_.hash, clock_.now().utc};
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await writer_.configurations().continue_run(record.id, used));
  }
  co_return basis;
}

Awaitable<Result<void>> RunsService::continue_unfinished() {
  DRIFTWISE_CO_TRY(auto unfinished, co_await find_unfinished());
  if (!unfinished) co_return Result<void>{};
  auto record = std::move(*unfinished);
  const auto found = record;  // as the last daemon left it
  auto reading = read_basis(found);
  auto basis = co_await std::move(reading);
  if (const auto stops = stops_.records(); !stops.empty()) {
    record.state = RunState::paused;
    record.reason = stops.front().cause;
  } else if (const auto& cause = stops_.cause_at_start()) {
    record.state = RunState::paused;
    record.reason = *cause;
  }
  auto question = configuration_.question_for(record);
  // A stop pressed since the start, while this was read, found no run under way to halt.
  if (stop_events_.presses() > 0) pause_by_stop(record, stop_events_.hold());
  if (!basis) {
    engine_.begin_unread(std::move(record), basis.error(),
                         [this, found] { return read_basis(found); });
    co_return tl::unexpected(basis.error());
  }
  const bool was_paused = record.state == RunState::paused;  // then resume_run refuses meanwhile
  engine_.begin(std::move(record), std::move(basis->plan), std::move(basis->trajectory),
                std::move(basis->before), false);
  if (!question.empty() && !was_paused)
    engine_.control()->hold(
        {RunHold::Kind::configuration, "", clock_.now().utc, std::move(question)});
  co_return Result<void>{};
}

Awaitable<Result<RunBefore>> RunsService::what_was_before(const RunRecord& run) {
  const bool killed = run.reason != kShutDownReason && run.state != RunState::paused;
  co_return co_await reader_.call([killed, id = run.id](Store& store) -> Result<RunBefore> {
    constexpr int kPage = 1000;
    RunBefore before;
    before.killed = killed;
    DRIFTWISE_TRY(auto attempts, store.points().attempts(id));
    before.attempts = std::move(attempts);
    DRIFTWISE_TRY(auto data, store.points().data(id));
    before.data = std::move(data);
    DRIFTWISE_TRY(const auto repeated, store.closures().repeated_points(id));
    for (std::int64_t after = 0;;) {
      DRIFTWISE_TRY(auto page, store.points().points(id, after, kPage));
      if (page.empty()) break;
      after = page.back().id.value;
      for (auto& point : page)
        if (point.zero && !point.passage && !std::ranges::binary_search(repeated, point.id))
          before.zeros.push_back(std::move(point));
    }
    DRIFTWISE_TRY(before.closures, store.closures().closures(id));
    return before;
  });
}

}  // namespace driftwise::application
