#include "storage/runs/queue_store.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "storage/rows/run_rows.h"
#include "storage/rows/run_select.h"

namespace driftwise::storage {
namespace {

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// The columns in the order of the SELECT below.
QueueEntry entry_from(const Query& row, const std::string& file) {
  QueueEntry entry;
  entry.id = {row.integer(0)};
  entry.place = row.integer(1);
  const auto state = queue_state_from(row.text(2));
  const auto on_failure = on_failure_from(row.text(16));
  if (!state || !on_failure)
    throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                  "database " + file + ": queue_entry " + std::to_string(entry.id.value) +
                      " has state '" + row.text(2) + "' and on_failure '" + row.text(16) +
                      "': restore what was edited");
  entry.state = *state;
  entry.on_failure = *on_failure;
  entry.reason = row.text(3);
  entry.name = row.text(4);
  entry.trajectory_name = row.text(5);
  entry.trajectory_text = row.text(6);
  entry.rows = row.integer(7);
  entry.rules_json = row.text(8);
  entry.compensate = row.integer(9) != 0;
  if (const auto model = row.optional_integer(10)) entry.compensate_with = ModelId{*model};
  entry.metadata = metadata_from_lines(row.text(11));
  entry.priority = static_cast<int>(row.integer(12));
  entry.not_before = {row.integer(13)};
  if (const auto after = row.optional_integer(14)) entry.after = QueueEntryId{*after};
  entry.condition = row.text(15);
  entry.repeat_every_s = row.real(17);
  entry.follow_ups = split_lines(row.text(18));
  entry.request_id = row.text(19);
  entry.created = {row.integer(20)};
  entry.created_by = row.text(21);
  entry.created_from = row.text(22);
  if (const auto run = row.optional_integer(23)) entry.run = RunId{*run};
  entry.begun = {row.integer(24)};
  entry.ended = {row.integer(25)};
  return entry;
}

std::vector<QueueResult> results_of(Session& session, QueueEntryId id) {
  Query query(session.db,
              "SELECT position, good, text, model_id, diagnosis_id, at_ns FROM queue_result WHERE "
              "entry_id = ? ORDER BY position");
  query.bind(id);
  std::vector<QueueResult> results;
  while (query.row()) {
    QueueResult result;
    result.position = static_cast<int>(query.integer(0));
    result.good = query.integer(1) != 0;
    result.text = query.text(2);
    if (const auto model = query.optional_integer(3)) result.model = ModelId{*model};
    if (const auto found = query.optional_integer(4)) result.diagnosis = DiagnosisId{*found};
    result.at = {query.integer(5)};
    results.push_back(std::move(result));
  }
  return results;
}

void put_entry(Session& session, const QueueEntry& entry) {
  Query(session.db,
        "INSERT INTO queue_entry (entry_id, place, state, reason, name, trajectory_name, "
        "trajectory_text, trajectory_rows, rules_json, compensate, compensate_model_id, metadata, "
        "priority, not_before_ns, after_entry_id, condition, on_failure, repeat_every_s, "
        "follow_ups, request_id, created_ns, created_by, created_from, run_id, begun_ns, ended_ns) "
        "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, "
        "?19, ?20, ?21, ?22, ?23, ?24, ?25, ?26) ON CONFLICT (entry_id) DO UPDATE SET place = ?2, "
        "state = ?3, reason = ?4, name = ?5, rules_json = ?9, compensate = ?10, "
        "compensate_model_id = ?11, metadata = ?12, priority = ?13, not_before_ns = ?14, "
        "after_entry_id = ?15, condition = ?16, on_failure = ?17, repeat_every_s = ?18, "
        "follow_ups = ?19, run_id = ?24, begun_ns = ?25, ended_ns = ?26")
      .bind(entry.id, entry.place, to_string(entry.state), entry.reason, entry.name,
            entry.trajectory_name, entry.trajectory_text, entry.rows, entry.rules_json,
            entry.compensate ? 1 : 0, entry.compensate_with, metadata_lines(entry.metadata),
            entry.priority, entry.not_before.ns, entry.after, entry.condition,
            to_string(entry.on_failure), entry.repeat_every_s, joined_lines(entry.follow_ups),
            entry.request_id, entry.created.utc_ns, entry.created_by, entry.created_from, entry.run,
            entry.begun.utc_ns, entry.ended.utc_ns)
      .run();
  Query(session.db, "DELETE FROM queue_result WHERE entry_id = ?").bind(entry.id).run();
  for (const auto& result : entry.results)
    Query(session.db,
          "INSERT INTO queue_result (entry_id, position, good, text, model_id, diagnosis_id, "
          "at_ns) VALUES (?, ?, ?, ?, ?, ?, ?)")
        .bind(entry.id, result.position, result.good ? 1 : 0, result.text, result.model,
              result.diagnosis, result.at.utc_ns)
        .run();
}

}  // namespace

Result<QueueRecord> SqliteQueueStore::queue(int history) {
  return session_.read([&] {
    QueueRecord record;
    Query query(session_.db,
                "SELECT entry_id, place, state, reason, name, trajectory_name, CASE WHEN state IN "
                "('done', 'removed') THEN '' ELSE trajectory_text END, trajectory_rows, "
                "rules_json, compensate, compensate_model_id, metadata, priority, not_before_ns, "
                "after_entry_id, condition, on_failure, repeat_every_s, follow_ups, request_id, "
                "created_ns, created_by, created_from, run_id, begun_ns, ended_ns FROM queue_entry "
                "WHERE state NOT IN ('done', 'removed') OR entry_id IN (SELECT after_entry_id FROM "
                "queue_entry WHERE state NOT IN ('done', 'removed')) OR entry_id > (SELECT "
                "coalesce(max(entry_id), 0) FROM queue_entry) - ? ORDER BY entry_id");
    query.bind(history);
    while (query.row()) record.entries.push_back(entry_from(query, session_.db.path()));
    for (auto& entry : record.entries) entry.results = results_of(session_, entry.id);
    Query hold(session_.db, "SELECT held, who, why, at_ns FROM queue_hold WHERE one = 1");
    if (hold.row())
      record.hold = {hold.integer(0) != 0, hold.text(1), hold.text(2), {hold.integer(3)}};
    return record;
  });
}

Result<void> SqliteQueueStore::change_queue(const QueueChange& change) {
  return session_.write([&] {
    for (const auto& entry : change.put) put_entry(session_, entry);
    if (change.hold)
      Query(session_.db,
            "INSERT INTO queue_hold (one, held, who, why, at_ns) VALUES (1, ?, ?, ?, ?) ON "
            "CONFLICT (one) DO UPDATE SET held = excluded.held, who = excluded.who, why = "
            "excluded.why, at_ns = excluded.at_ns")
          .bind(change.hold->held ? 1 : 0, change.hold->who, change.hold->why,
                change.hold->at.utc_ns)
          .run();
  });
}

Result<RunRecord> SqliteMetadataStore::tag(RunId run, const RunMetadata& set,
                                           const std::vector<std::string>& removed) {
  return session_.write([&] {
    require_run(session_, run);
    for (const auto& key : removed)
      Query(session_.db, "DELETE FROM run_metadata WHERE run_id = ? AND key = ?")
          .bind(run, key)
          .run();
    for (const auto& item : set)
      Query(session_.db,
            "INSERT INTO run_metadata (run_id, key, value) VALUES (?, ?, ?) ON CONFLICT DO UPDATE "
            "SET value = excluded.value")
          .bind(run, item.key, item.value)
          .run();
    return read_run(session_, run);
  });
}

Result<std::vector<RunRecord>> SqliteMetadataStore::find_runs(const RunMetadata& all_of, int limit,
                                                              std::int64_t before_id) {
  return session_.read([&] {
    // Wanted pairs as one text: the runs that lack none of them.
    Query query(session_.db, DRIFTWISE_LIST_RUNS
                " WHERE (?1 <= 0 OR run_id < ?1) AND (SELECT count(*) FROM run_metadata w WHERE "
                "w.run_id = run.run_id AND instr(?3, char(10) || w.key || '=' || w.value || "
                "char(10)) > 0) = ?4 ORDER BY run_id DESC LIMIT ?2");
    query.bind(before_id, limit > 0 ? limit : -1, "\n" + metadata_lines(all_of),
               static_cast<std::int64_t>(all_of.size()));
    std::vector<RunRecord> runs;
    while (query.row()) runs.push_back(run_from(query, session_.db.path()));
    return runs;
  });
}

}  // namespace driftwise::storage
