#include "storage/diagnosis/diagnosis_store.h"

#include "server/core/reasons.h"
#include "storage/diagnosis/extension_rows.h"
#include "storage/diagnosis/improvement_rows.h"
#include "storage/models/model_store.h"
#include "storage/rows/run_rows.h"

namespace driftwise::storage {
namespace {

std::vector<RunId> runs_of(Session& session, DiagnosisId id) {
  Query query(session.db,
              "SELECT run_id FROM diagnosis_run WHERE diagnosis_id = ? ORDER BY position");
  query.bind(id);
  std::vector<RunId> runs;
  while (query.row()) runs.push_back({query.integer(0)});
  return runs;
}

// The columns of diagnosis in the order of the SELECTs below.
DiagnosisRecord diagnosis_from(const Query& row) {
  DiagnosisRecord record;
  record.id = {row.integer(0)};
  record.name = row.text(1);
  record.state = job_state_from(row.text(2)).value_or(JobState::failed);
  record.reason = row.text(3);
  if (const auto model = row.optional_integer(4)) record.model = ModelId{*model};
  record.baseline = row.text(5);
  record.extended = row.text(6);
  record.request_json = row.text(7);
  record.result_json = row.text(8);
  record.created.utc_ns = row.integer(9);
  record.created_by = row.text(10);
  record.ended.utc_ns = row.integer(11);
  return record;
}

DiagnosisRecord read_diagnosis(Session& session, DiagnosisId id) {
  Query query(session.db,
              "SELECT diagnosis_id, name, state, reason, model_id, baseline, extended, "
              "request_json, result_json, created_ns, created_by, ended_ns FROM diagnosis WHERE "
              "diagnosis_id = ?");
  if (!query.bind(id).row()) throw_no_such_diagnosis(session, id);
  auto record = diagnosis_from(query);
  record.runs = runs_of(session, id);
  return record;
}

}  // namespace

Result<DiagnosisRecord> SqliteDiagnosisStore::add_diagnosis(const DiagnosisRecord& wanted) {
  return session_.write([&] {
    for (const RunId run : wanted.runs) require_run(session_, run);
    if (wanted.model) require_model(session_, *wanted.model);
    Query(session_.db,
          "INSERT INTO diagnosis (name, state, reason, model_id, baseline, extended, request_json, "
          "result_json, created_ns, created_by, ended_ns) VALUES (?, 'running', '', ?, ?, '', ?, "
          "'', ?, ?, 0)")
        .bind(wanted.name, wanted.model, wanted.baseline, wanted.request_json,
              wanted.created.utc_ns, wanted.created_by)
        .run();
    const DiagnosisId id{session_.db.last_row_id()};
    Query run_of(session_.db,
                 "INSERT INTO diagnosis_run (diagnosis_id, position, run_id) VALUES (?, ?, ?)");
    int position = 0;
    for (const RunId run : wanted.runs) run_of.bind(id, position++, run).run();
    return read_diagnosis(session_, id);
  });
}

Result<void> SqliteDiagnosisStore::end_diagnosis(DiagnosisId id, const DiagnosisEnd& end) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE diagnosis SET state = ?, reason = ?, extended = ?, result_json = ?, rows_cbor = "
          "?, ended_ns = ? WHERE diagnosis_id = ? AND state = 'running'")
        .bind(to_string(end.state), end.reason, end.extended, end.result_json, Bytes{end.rows},
              end.at.utc_ns, id)
        .run();
    if (session_.db.changed_rows() == 1) return;
    const auto stored = read_diagnosis(session_, id);
    throw_failure(ErrorCode::failed_precondition, reasons::kAlreadyOver,
                  "diagnosis " + std::to_string(id.value) + " is over: it is " +
                      std::string(to_string(stored.state)));
  });
}

Result<DiagnosisRecord> SqliteDiagnosisStore::diagnosis(DiagnosisId id) {
  return session_.read([&] { return read_diagnosis(session_, id); });
}

Result<std::vector<DiagnosisRecord>> SqliteDiagnosisStore::diagnoses(int limit) {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT diagnosis_id, name, state, reason, model_id, baseline, extended, "
                "request_json, result_json, created_ns, created_by, ended_ns FROM diagnosis ORDER "
                "BY diagnosis_id DESC LIMIT ?");
    query.bind(limit > 0 ? limit : -1);
    std::vector<DiagnosisRecord> records;
    while (query.row()) records.push_back(diagnosis_from(query));
    for (auto& record : records) record.runs = runs_of(session_, record.id);
    return records;
  });
}

Result<std::string> SqliteDiagnosisStore::diagnosis_rows(DiagnosisId id) {
  return session_.read([&] {
    Query query(session_.db, "SELECT rows_cbor FROM diagnosis WHERE diagnosis_id = ?");
    if (!query.bind(id).row()) throw_no_such_diagnosis(session_, id);
    return query.bytes(0);
  });
}

Result<ExtensionRecord> SqliteExtensionStore::accept(const NewExtension& extension) {
  return session_.write([&] { return insert_extension(session_, extension); });
}

Result<ExtensionRecord> SqliteExtensionStore::undo_extension(
    DiagnosisId id, const Stamp& at, const std::string& who, const std::string& from,
    const std::optional<PromotionRecord>& rollback) {
  return session_.write([&] { return undo_extension_row(session_, id, at, who, from, rollback); });
}

Result<std::optional<ExtensionRecord>> SqliteExtensionStore::extension(DiagnosisId id) {
  return session_.read([&] {
    require_diagnosis(session_, id);
    return read_extension(session_, id);
  });
}

Result<std::vector<CorrectionRecord>> SqliteExtensionStore::corrections() {
  return session_.read([&] { return read_corrections(session_); });
}

Result<ImprovementRecord> SqliteImprovementStore::add_improvement(const ImprovementRecord& wanted) {
  return session_.write([&] { return insert_improvement(session_, wanted); });
}

Result<void> SqliteImprovementStore::put_turn(ImprovementId id, const ImprovementTurn& turn) {
  return session_.write([&] { put_turn_row(session_, id, turn); });
}

Result<void> SqliteImprovementStore::end_improvement(ImprovementId id, JobState state,
                                                     const std::string& reason, CellTime at) {
  return session_.write([&] { end_improvement_row(session_, id, state, reason, at); });
}

Result<ImprovementRecord> SqliteImprovementStore::improvement(ImprovementId id) {
  return session_.read([&] { return read_improvement(session_, id); });
}

Result<std::vector<ImprovementRecord>> SqliteImprovementStore::improvements(int limit) {
  return session_.read([&] { return read_improvements(session_, limit); });
}

Result<std::int64_t> SqliteDiagnosisStore::fail_unfinished(const std::string& reason, CellTime at) {
  return session_.write([&] {
    std::int64_t count = 0;
    for (const char* sql :
         {"UPDATE diagnosis SET state = 'failed', reason = ?, ended_ns = ? WHERE state = 'running'",
          "UPDATE improvement SET state = 'failed', reason = ?, ended_ns = ? WHERE state = "
          "'running'"}) {
      Query(session_.db, sql).bind(reason, at.utc_ns).run();
      count += session_.db.changed_rows();
    }
    return count;
  });
}

}  // namespace driftwise::storage
