#include "server/application/runs/suspects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/until_stored.h"
#include "server/application/recording/doubts.h"
#include "server/application/runs/active_run.h"
#include "server/application/runs/run_engine.h"
#include "server/core/try.h"
#include "server/formats/text/row_ranges.h"

namespace driftwise::application {

std::vector<std::int64_t> SinceClosure::take(CellTime since) {
  std::vector<std::int64_t> rows;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    auto& point = points_[i];
    if (point.taken || (i < confirmed_ && point.measured <= since)) continue;
    point.taken = true;
    rows.push_back(point.row);
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

std::vector<std::int64_t> SinceClosure::take_from(CellTime since, std::optional<CellTime> until) {
  std::vector<std::int64_t> rows;
  for (auto& point : points_) {
    if (point.taken || point.measured < since || (until && point.measured > *until)) continue;
    point.taken = true;
    rows.push_back(point.row);
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

Awaitable<Result<void>> mark_suspects(ActiveRun& run, CellTime since, std::string reason) {
  auto rows = run.since_closure.take(since);
  co_return co_await mark_rows(run, std::move(rows), std::move(reason));
}

Awaitable<Result<void>> mark_rows(ActiveRun& run, std::vector<std::int64_t> rows,
                                  std::string reason) {
  ExclusionRecord mark;
  mark.run = run.record.id;
  mark.rows = std::move(rows);
  if (mark.rows.empty()) co_return Result<void>{};
  mark.reason = std::move(reason);
  mark.at = run.scope.bench.clock.now();
  mark.who = "daemon";
  mark.suspect = true;
  // Through stops and an abort: the rows are asked for once, and would stay in fits.
  const auto store = [&run, &mark] { return run.scope.bench.writer.remarks().exclude(mark); };
  auto storing = until_stored(run.scope, store, EndsWait::the_daemon_alone);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  std::vector<std::int64_t> from_one;
  for (const auto row : mark.rows) from_one.push_back(row + 1);
  auto detail = fmt::format("rows {} of run {} are suspect and kept out of fits: {}",
                            formats::row_ranges_text(from_one), mark.run.value, mark.reason);
  run.scope.bench.events.record_own("data.suspect", std::move(detail), mark.run);
  co_return Result<void>{};
}

Awaitable<Result<void>> mark_doubted(ActiveRun& run) {
  auto suspicion = run.scope.bench.doubts.take_suspicion();
  if (!suspicion) co_return Result<void>{};
  co_return co_await mark_suspects(run, suspicion->since, std::move(suspicion->reason));
}

void add_line_under_way(ActiveRun& run, const RunBefore& before) {
  std::int64_t line = 0;
  CellTime last_zero;
  for (const auto& zero : before.zeros) last_zero = std::max(last_zero, zero.measured.utc);
  for (const auto& closure : before.closures) last_zero = std::max(last_zero, closure.measured.utc);
  const auto row_of = [&run](const AttemptRecord& attempt) -> const TrajectoryPoint& {
    return run.trajectory.points[static_cast<std::size_t>(attempt.row)];
  };
  const auto is_open = [last_zero](const AttemptRecord& attempt) {
    return attempt.verdict == Verdict::accepted && attempt.ended.utc > last_zero;
  };
  // What is visited again has no point to mark.
  const auto is_decided = [&run](const AttemptRecord& attempt) {
    const auto& place = run.record.place;
    return attempt.row < place.next_row &&
           std::ranges::find(place.requeued, attempt.row, &Requeued::row) == place.requeued.end();
  };
  for (const auto& attempt : before.attempts)
    if (is_open(attempt)) line = row_of(attempt).line;
  for (const auto& attempt : before.attempts)
    if (is_open(attempt) && is_decided(attempt) && row_of(attempt).line == line)
      run.since_closure.add(attempt.row, attempt.ended.utc);
}

Awaitable<Result<void>> mark_after_datum(ActiveRun& run) {
  const double* difference_nm = find_value(run.datum->values, "zero_difference_nm");
  const double* limit_nm = find_value(run.datum->values, "zero_limit_nm");
  if (difference_nm == nullptr || limit_nm == nullptr) co_return Result<void>{};
  if (std::abs(*difference_nm) <= std::abs(*limit_nm)) {
    run.since_closure.close();
    co_return Result<void>{};
  }
  auto reason = fmt::format(
      "at datum {} the old zero was {:+.0f} nm from where it was expected (limit {:.0f})",
      run.datum->id.value, *difference_nm, *limit_nm);
  auto marking = mark_suspects(run, run.datum->opened.utc, std::move(reason));
  co_return co_await std::move(marking);
}

}  // namespace driftwise::application
