#include "storage/runs/run_store.h"

#include "storage/datasets/dataset_import.h"
#include "storage/datasets/dataset_query.h"
#include "storage/rows/place_text.h"
#include "storage/rows/point_rows.h"
#include "storage/rows/reading_rows.h"
#include "storage/rows/run_rows.h"
#include "storage/rows/run_select.h"

namespace driftwise::storage {
namespace {

// A stop that was stored while this run was on its way here found no run to pause.
void pause_when_stopped(Session& session, RunId run, CellTime created) {
  Query stop(session.db,
             "SELECT cause FROM stop WHERE asked_ns >= ? ORDER BY asked_ns DESC LIMIT 1");
  if (!stop.bind(created.utc_ns).row()) return;
  RunChange paused;
  paused.state = RunState::paused;
  paused.reason = stop.text(0);
  change_run_row(session, run, paused);
}

}  // namespace

Result<RunRecord> SqliteRunStore::create_run(const NewRun& run) {
  return session_.write([&] {
    if (auto earlier = run_of_request(session_, run)) return *std::move(earlier);
    const RunId id = insert_run(session_, run, RunState::queued);
    pause_when_stopped(session_, id, run.created.utc);
    return read_run(session_, id);
  });
}

Result<void> SqliteRunStore::change_run(RunId run, const RunChange& change) {
  return session_.write([&] { change_run_row(session_, run, change); });
}

Result<DatumId> SqlitePointStore::open_datum(const DatumRecord& datum) {
  return session_.write([&] { return insert_datum(session_, datum, std::nullopt); });
}

Result<std::optional<PointId>> SqlitePointStore::commit(const PointCommit& commit) {
  return session_.write([&] {
    std::int64_t given_up = 0;
    for (const AttemptRecord& attempt : commit.attempts) {
      insert_readings(session_, attempt.readings, insert_attempt(session_, commit.run, attempt));
      given_up += attempt.verdict == Verdict::given_up ? 1 : 0;
    }
    insert_readings(session_, commit.slow_readings, std::nullopt);
    insert_moves(session_, commit.moves);
    insert_rejected(session_, commit.rejected);
    insert_passages(session_, commit.run, commit.passages);
    std::optional<PointId> id;
    if (commit.point) id = insert_point(session_, commit.run, *commit.point, {});
    Query(session_.db,
          "UPDATE run_progress SET next_row = ?2, requeued = ?3, accepted = accepted + ?4, "
          "given_up = given_up + ?5, "
          "attempts = attempts + ?6 WHERE run_id = ?1")
        .bind(commit.run.value, commit.place.next_row, requeued_text(commit.place.requeued),
              id ? 1 : 0, given_up, static_cast<std::int64_t>(commit.attempts.size()))
        .run();
    if (session_.db.changed_rows() == 0) throw_no_such_run(session_, commit.run);
    return id;
  });
}

Result<RunRecord> SqliteRunStore::run(RunId run) {
  return session_.read([&] { return read_run(session_, run); });
}

Result<std::vector<RunRecord>> SqliteRunStore::runs(int limit, std::int64_t before_id) {
  return session_.read([&] {
    Query query(session_.db,
                DRIFTWISE_LIST_RUNS " WHERE ?1 <= 0 OR run_id < ?1 ORDER BY run_id DESC LIMIT ?2");
    query.bind(before_id, limit > 0 ? limit : -1);
    std::vector<RunRecord> runs;
    while (query.row()) runs.push_back(run_from(query, session_.db.path()));
    return runs;
  });
}

Result<std::optional<RunRecord>> SqliteRunStore::unfinished_run() {
  return session_.read([&]() -> std::optional<RunRecord> {
    Query query(session_.db, DRIFTWISE_SELECT_RUN
                " WHERE state IN ('running', 'paused', 'waiting') ORDER BY run_id DESC LIMIT 1");
    if (!query.row()) return std::nullopt;
    return run_from(query, session_.db.path());
  });
}

Result<std::vector<PointRecord>> SqlitePointStore::points(RunId run, std::int64_t after_id,
                                                          int limit) {
  return session_.read([&] {
    require_run(session_, run);
    return read_points(session_, run, after_id, limit);
  });
}

Result<std::vector<AttemptRecord>> SqlitePointStore::attempts(RunId run) {
  return session_.read([&] {
    require_run(session_, run);
    return read_attempts(session_, run);
  });
}

Result<std::vector<DatumRecord>> SqlitePointStore::data(RunId run) {
  return session_.read([&] {
    require_run(session_, run);
    return read_datums(session_, run);
  });
}

Result<std::optional<DatumRecord>> SqlitePointStore::newest_datum() {
  return session_.read([&] { return read_newest_datum(session_); });
}

Result<RunRecord> SqliteRunStore::import_dataset(const NewRun& run, const Dataset& dataset) {
  return session_.write([&] {
    if (auto earlier = run_of_request(session_, run)) return *std::move(earlier);
    return read_run(session_, import_rows(session_, run, dataset));
  });
}

Result<Dataset> SqliteRunStore::dataset(std::span<const RunId> runs) {
  return session_.read([&] { return read_dataset(session_, runs); });
}

}  // namespace driftwise::storage
