#include "storage/runs/closure_store.h"

#include "server/core/reasons.h"
#include "storage/rows/place_text.h"
#include "storage/rows/run_rows.h"
#include "storage/watch/remark_store.h"

namespace driftwise::storage {
namespace {

void insert_coordinates(Session& session, std::int64_t id, const ClosureRecord& closure) {
  Query row(session.db,
            "INSERT OR IGNORE INTO closure_coordinate (closure_id, channel_id, found, allowed, "
            "expected, expected_sd, noise, play) VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  for (const auto& one : closure.coordinates)
    row.bind(id, session.names.channel(one.channel, Names::Use::datum), one.found, one.limit,
             one.expected, one.expected_sd, one.noise, one.play)
        .run();
}

// Marks of the daemon are on rows, and what they said was of the points before.
void take_marks_back(Session& session, const ClosureRecord& closure,
                     const std::vector<std::int64_t>& rows) {
  ExclusionRecord back;
  back.run = closure.run;
  back.excluded = false;
  back.at = closure.measured;
  back.who = "daemon";
  back.reason = "line " + std::to_string(closure.line) + " is measured again";
  Query marked(session.db, "SELECT 1 FROM suspect_point WHERE run_id = ? AND trajectory_row = ?");
  for (const std::int64_t row : rows) {
    if (marked.bind(closure.run, row).row()) back.rows.push_back(row);
    marked.restart();
  }
  if (!back.rows.empty()) store_exclusion(session, back);
}

void repeat_line(Session& session, std::int64_t id, const ClosureRecord& closure,
                 const RepeatedLine& line) {
  take_marks_back(session, closure, line.rows);
  Query point(session.db,
              "INSERT INTO repeated_point (point_id, closure_id) SELECT point_id, ?3 FROM point "
              "WHERE run_id = ?1 AND trajectory_row = ?2 AND point_id NOT IN (SELECT point_id FROM "
              "repeated_point)");
  std::int64_t points = 0;
  for (const std::int64_t row : line.rows) {
    point.bind(closure.run, row, id).run();
    points += session.db.changed_rows();
  }
  // With the way over them: what is left ends with the last point that counts.
  Query(session.db,
        "INSERT INTO repeated_point (point_id, closure_id) SELECT point_id, ?2 FROM passage JOIN "
        "point USING (point_id) WHERE run_id = ?1 AND point_id > coalesce((SELECT max(point_id) "
        "FROM planned_point WHERE run_id = ?1 AND point_id NOT IN (SELECT point_id FROM "
        "repeated_point)), 0) AND point_id NOT IN (SELECT point_id FROM repeated_point)")
      .bind(closure.run, id)
      .run();
  Query(session.db,
        "UPDATE run_progress SET next_row = ?2, requeued = ?3, accepted = accepted - ?4, given_up "
        "= given_up - ?5 WHERE run_id = ?1")
      .bind(closure.run, line.place.next_row, requeued_text(line.place.requeued), points,
            line.given_up)
      .run();
}

ClosureRecord closure_from(Session& session, RunId run, const Query& query) {
  ClosureRecord closure;
  closure.id = query.integer(0);
  closure.run = run;
  closure.datum = {query.integer(1)};
  closure.line = query.integer(2);
  closure.repetition = static_cast<int>(query.integer(3));
  closure.measured = {{query.integer(4)}, query.integer(5)};
  closure.side = query.text(6);
  closure.by = query.text(7);
  const auto decision = closure_decision_from(query.text(8));
  if (!decision)
    throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                  "database " + session.db.path() + ": table closure has the decision '" +
                      query.text(8) + "', which no Driftwise wrote: restore what was edited");
  closure.decision = *decision;
  closure.sentence = query.text(9);
  return closure;
}

}  // namespace

Result<std::int64_t> SqliteClosureStore::add_closure(const ClosureRecord& closure,
                                                     const std::optional<RepeatedLine>& repeated) {
  return session_.write([&] {
    require_run(session_, closure.run);
    Query(session_.db,
          "INSERT INTO closure (run_id, datum_id, line, repetition, measured_ns, "
          "measured_monotonic_ns, side, expected_by, decision, sentence) VALUES (?, ?, ?, ?, ?, ?, "
          "?, ?, ?, ?)")
        .bind(closure.run, closure.datum, closure.line, closure.repetition,
              closure.measured.utc.utc_ns, closure.measured.monotonic_ns, closure.side, closure.by,
              to_string(closure.decision), closure.sentence)
        .run();
    const std::int64_t id = session_.db.last_row_id();
    insert_coordinates(session_, id, closure);
    if (repeated) repeat_line(session_, id, closure, *repeated);
    return id;
  });
}

Result<std::vector<ClosureRecord>> SqliteClosureStore::closures(RunId run) {
  return session_.read([&] {
    require_run(session_, run);
    Query query(session_.db,
                "SELECT closure_id, datum_id, line, repetition, measured_ns, "
                "measured_monotonic_ns, side, expected_by, decision, sentence FROM closure WHERE "
                "run_id = ? ORDER BY closure_id");
    Query parts(session_.db,
                "SELECT channel_id, found, allowed, expected, expected_sd, noise, play FROM "
                "closure_coordinate WHERE closure_id = ? ORDER BY channel_id");
    query.bind(run);
    std::vector<ClosureRecord> closures;
    while (query.row()) {
      auto closure = closure_from(session_, run, query);
      parts.bind(closure.id);
      while (parts.row())
        closure.coordinates.push_back({session_.names.channel_name(parts.integer(0)), parts.real(1),
                                       parts.real(2), parts.real(3), parts.real(4), parts.real(5),
                                       parts.real(6)});
      parts.restart();
      closures.push_back(std::move(closure));
    }
    return closures;
  });
}

Result<std::vector<PointId>> SqliteClosureStore::repeated_points(RunId run) {
  return session_.read([&] {
    require_run(session_, run);
    // CROSS: few points were repeated, a run has many.
    Query query(session_.db,
                "SELECT point_id FROM repeated_point CROSS JOIN point USING (point_id) WHERE "
                "run_id = ? ORDER BY point_id");
    query.bind(run);
    std::vector<PointId> points;
    while (query.row()) points.push_back({query.integer(0)});
    return points;
  });
}

}  // namespace driftwise::storage
