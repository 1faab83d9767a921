#include "server/application/trajectories/duration_book.h"

#include "server/application/ports/run_plan.h"
#include "server/core/try.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::application {
namespace {

constexpr int kRunsLookedAt = 60;
constexpr int kEventPage = 2000;

// The last event before an instant; events are stored in the order of time.
Result<std::int64_t> event_before(Store& store, CellTime instant) {
  std::int64_t low = 0, high = 1;
  const auto is_later = [&](std::int64_t after) -> Result<bool> {
    DRIFTWISE_TRY(const auto next, store.events().events(EventId{after}, 1));
    return next.empty() || next.front().at.utc >= instant;
  };
  while (true) {
    DRIFTWISE_TRY(const bool later, is_later(high));
    if (later) break;
    low = high;
    high *= 2;
  }
  while (low + 1 < high) {
    const auto middle = low + (high - low) / 2;
    DRIFTWISE_TRY(const bool later, is_later(middle));
    (later ? high : low) = middle;
  }
  return low;
}

bool lets_continue(const EventRecord& event) {
  return event.what == "run.resume" || event.what == "run.restarted" ||
         event.what == "configuration.accepted";
}

Result<std::vector<CellTime>> instants_of_continuing(Store& store, const RunRecord& run) {
  std::vector<CellTime> instants;
  DRIFTWISE_TRY(auto after, event_before(store, run.started));
  while (true) {
    DRIFTWISE_TRY(const auto events, store.events().events(EventId{after}, kEventPage));
    for (const auto& event : events) {
      if (run.ended.utc_ns != 0 && event.at.utc > run.ended) return instants;
      if (lets_continue(event)) instants.push_back(event.at.utc);
    }
    if (events.size() < static_cast<std::size_t>(kEventPage)) return instants;
    after = events.back().id.value;
  }
}

Result<RunSteps> recorded_steps(Store& store, const RunRecord& listed) {
  DRIFTWISE_TRY(const auto run, store.runs().run(listed.id));  // a list has no trajectories
  DRIFTWISE_TRY(const auto trajectory,
                formats::read_trajectory_csv(run.trajectory_text, run.trajectory_name));
  DRIFTWISE_TRY(const auto plan, read_run_plan(run.rules_json));
  DRIFTWISE_TRY(const auto meter,
                recorded_meter(store, run, PlanLength(trajectory), planned_visit_s(plan.rules)));
  return meter.steps();
}

}  // namespace

Result<StepMeter> recorded_meter(Store& store, const RunRecord& run, const PlanLength& plan,
                                 double unit_s) {
  DRIFTWISE_TRY(const auto attempts, store.points().attempts(run.id));
  DRIFTWISE_TRY(const auto kept, instants_of_continuing(store, run));
  return meter_of(run, attempts, plan, unit_s, kept);
}

Awaitable<void> DurationBook::load() {
  const auto runs =
      co_await reader_.call([](Store& store) { return store.runs().runs(kRunsLookedAt, 0); });
  if (!runs) co_return;
  std::vector<RunSteps> found;
  for (const auto& run : *runs) {
    // A dataset that was measured elsewhere has no attempts of this cell.
    if (!is_over(run.state) || run.attempts == 0) continue;
    auto steps = co_await reader_.call(recorded_steps, run);
    if (steps) found.push_back(std::move(*steps));
    if (found.size() == DurationHistory::kMostRuns) break;
  }
  // Runs that ended meanwhile are newer than all of these.
  auto all = std::make_shared<DurationHistory>();
  for (auto run = found.rbegin(); run != found.rend(); ++run) all->add(std::move(*run));
  all->add_all(*history_);
  history_ = std::move(all);
}

void DurationBook::add(RunSteps run) {
  auto all = std::make_shared<DurationHistory>(*history_);
  all->add(std::move(run));
  history_ = std::move(all);
}

}  // namespace driftwise::application
