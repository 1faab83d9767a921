#include "storage/rows/run_rows.h"

#include "server/core/reasons.h"
#include "storage/rows/place_text.h"
#include "storage/rows/run_select.h"

namespace driftwise::storage {

namespace {

void begin_queue_entry(Session& session, QueueEntryId entry, RunId run, CellTime at) {
  Query(session.db, "INSERT INTO queue_run (run_id, entry_id) VALUES (?, ?)")
      .bind(run, entry)
      .run();
  Query(session.db,
        "UPDATE queue_entry SET state = 'running', reason = '', run_id = ?, begun_ns = ?, "
        "ended_ns = 0 WHERE entry_id = ?")
      .bind(run, at.utc_ns, entry)
      .run();
}

}  // namespace

RunId insert_run(Session& session, const NewRun& run, RunState state) {
  Query(session.db, "INSERT OR IGNORE INTO cell_config (hash, text) VALUES (?, ?)")
      .bind(run.config_hash, run.config_text)
      .run();
  Query(session.db,
        "INSERT INTO run (name, trajectory_name, trajectory_text, trajectory_rows, rules_json, "
        "config_hash, "
        "operator_name, request_id, created_ns, created_monotonic_ns) VALUES (?, ?, ?, ?, ?, ?, ?, "
        "?, ?, ?)")
      .bind(run.name, run.trajectory_name, run.trajectory_text, run.rows, run.rules_json,
            run.config_hash, run.operator_name, run.request_id, run.created.utc.utc_ns,
            run.created.monotonic_ns)
      .run();
  const RunId id{session.db.last_row_id()};
  Query(session.db, "INSERT INTO run_progress (run_id, state, boot_id) VALUES (?, ?, ?)")
      .bind(id.value, to_string(state), run.boot_id)
      .run();
  Query item(session.db, "INSERT INTO run_metadata (run_id, key, value) VALUES (?, ?, ?)");
  for (const auto& one : run.metadata) item.bind(id, one.key, one.value).run();
  if (run.queue_entry) begin_queue_entry(session, *run.queue_entry, id, run.created.utc);
  return id;
}

std::optional<RunRecord> run_of_request(Session& session, const NewRun& run) {
  if (run.request_id.empty()) return std::nullopt;
  Query query(session.db, DRIFTWISE_SELECT_RUN " WHERE request_id = ? AND request_id <> ''");
  query.bind(run.request_id);
  if (!query.row()) return std::nullopt;
  RunRecord earlier = run_from(query, session.db.path());
  // An import has no trajectory; its rules name its contents instead.
  const bool is_import = run.trajectory_text.empty();
  if (earlier.trajectory_text != run.trajectory_text || earlier.name != run.name ||
      (is_import && earlier.rules_json != run.rules_json))
    throw_failure(
        ErrorCode::already_exists, reasons::kRequestIdReused,
        "request '" + run.request_id + "' made run " + std::to_string(earlier.id.value) + " '" +
            earlier.name +
            "' before, with another name or content: give each new run a request id of its own");
  return earlier;
}

RunRecord read_run(Session& session, RunId run) {
  Query query(session.db, DRIFTWISE_SELECT_RUN " WHERE run_id = ?");
  query.bind(run.value);
  if (!query.row()) throw_no_such_run(session, run);
  return run_from(query, session.db.path());
}

void require_run(Session& session, RunId run) {
  Query query(session.db, "SELECT 1 FROM run_progress WHERE run_id = ?");
  if (!query.bind(run.value).row()) throw_no_such_run(session, run);
}

void throw_no_such_run(Session& session, RunId run) {
  throw_failure(ErrorCode::not_found, reasons::kNoSuchRun,
                "there is no run " + std::to_string(run.value) + " in database " +
                    session.db.path() + ": 'driftwise run list' shows those there are");
}

void change_run_row(Session& session, RunId run, const RunChange& change) {
  const auto ns = [](const std::optional<CellTime>& time) {
    return time ? std::optional(time->utc_ns) : std::nullopt;
  };
  const auto state = change.state ? std::optional(to_string(*change.state)) : std::nullopt;
  std::optional<std::string_view> hold_kind;
  std::optional<std::string> hold_who;
  std::optional<std::int64_t> hold_ns;
  if (change.hold) {
    // A condition of the cell is looked at anew after a restart: the run's reason tells of it.
    const bool is_kept = change.hold->kind != RunHold::Kind::condition;
    hold_kind = is_kept ? to_string(change.hold->kind) : std::string_view();
    hold_who = change.hold->who;
    hold_ns = change.hold->at.utc_ns;
  }
  Query(session.db,
        "UPDATE run_progress SET state = coalesce(?2, state), reason = coalesce(?3, reason), "
        "started_ns = coalesce(?4, started_ns), ended_ns = coalesce(?5, ended_ns), "
        "max_lag_s = coalesce(?6, max_lag_s), restarts = coalesce(?7, restarts), "
        "hold_kind = coalesce(?8, hold_kind), hold_who = coalesce(?9, hold_who), "
        "hold_ns = coalesce(?10, hold_ns), boot_id = coalesce(?11, boot_id) WHERE run_id = ?1")
      .bind(run.value, state, change.reason, ns(change.started), ns(change.ended), change.max_lag_s,
            change.restarts, hold_kind, hold_who, hold_ns, change.boot_id)
      .run();
  if (session.db.changed_rows() == 0) throw_no_such_run(session, run);
}

}  // namespace driftwise::storage
