#include "storage/diagnosis/extension_rows.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "server/core/reasons.h"
#include "storage/models/model_store.h"
#include "storage/watch/remark_store.h"

namespace driftwise::storage {
namespace {

// Rows that this extension put out and that nobody has put back since.
std::vector<RowsOfRun> rows_kept_out(Session& session, std::int64_t extension) {
  Query query(session.db,
              "SELECT e.run_id, r.trajectory_row FROM extension_exclusion x "
              "JOIN exclusion e USING (exclusion_id) JOIN exclusion_row r USING (exclusion_id) "
              "WHERE x.extension_id = ? ORDER BY e.run_id, r.trajectory_row");
  query.bind(extension);
  std::vector<RowsOfRun> kept;
  while (query.row()) {
    const RunId run{query.integer(0)};
    if (kept.empty() || kept.back().run != run) kept.push_back({run, {}});
    kept.back().rows.push_back(query.integer(1));
  }
  return kept;
}

// Rows of a run that other extensions than this one keep out.
std::set<std::int64_t> rows_of_others(Session& session, std::int64_t extension, RunId run) {
  Query query(session.db,
              "SELECT r.trajectory_row FROM extension o JOIN extension_exclusion x USING "
              "(extension_id) JOIN exclusion e USING (exclusion_id) JOIN exclusion_row r USING "
              "(exclusion_id) WHERE o.undone_ns = 0 AND o.extension_id <> ? AND e.run_id = ?");
  query.bind(extension, run);
  std::set<std::int64_t> rows;
  while (query.row()) rows.insert(query.integer(0));
  return rows;
}

void keep_out(Session& session, std::int64_t extension, const ExclusionRecord& exclusion) {
  Query(session.db, "INSERT INTO extension_exclusion (extension_id, exclusion_id) VALUES (?, ?)")
      .bind(extension, exclusion.id)
      .run();
}

void insert_changes(Session& session, CorrectionId correction,
                    const std::vector<LengthChange>& changes) {
  std::int64_t position = 0;
  for (const auto& change : changes)
    Query(session.db,
          "INSERT INTO correction_change (correction_id, position, run_id, channel, from_ns, "
          "row_count, largest_nm, rms_nm, diagnosed) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(correction, position++, change.run, change.channel, change.from.utc_ns, change.rows,
              change.largest_nm, change.rms_nm, change.diagnosed ? 1 : 0)
        .run();
}

std::vector<LengthChange> read_changes(Session& session, CorrectionId correction) {
  Query query(session.db,
              "SELECT run_id, channel, from_ns, row_count, largest_nm, rms_nm, diagnosed, run.name "
              "FROM correction_change JOIN run USING (run_id) WHERE correction_id = ? "
              "ORDER BY position");
  query.bind(correction);
  std::vector<LengthChange> changes;
  while (query.row())
    changes.push_back({{query.integer(0)},
                       query.text(7),
                       query.text(1),
                       {query.integer(2)},
                       query.integer(3),
                       query.real(4),
                       query.real(5),
                       query.integer(6) != 0});
  return changes;
}

struct StoredExtension {
  std::int64_t id = 0;
  ExtensionRecord record;
};

std::optional<StoredExtension> last_extension(Session& session, DiagnosisId diagnosis) {
  Query query(session.db,
              "SELECT extension_id, findings, model_id, promoted, correction_id, accepted_ns, "
              "accepted_by, undone_ns, undone_by FROM extension WHERE diagnosis_id = ? "
              "ORDER BY extension_id DESC LIMIT 1");
  if (!query.bind(diagnosis).row()) return std::nullopt;
  StoredExtension stored;
  stored.id = query.integer(0);
  auto& record = stored.record;
  record.diagnosis = diagnosis;
  for (const std::int64_t number : numbers_from(query.text(1)))
    record.findings.push_back(static_cast<int>(number));
  if (const auto model = query.optional_integer(2)) record.model = ModelId{*model};
  record.promoted = query.integer(3) != 0;
  if (const auto correction = query.optional_integer(4))
    record.correction = CorrectionId{*correction};
  record.accepted.utc_ns = query.integer(5);
  record.accepted_by = query.text(6);
  record.undone.utc_ns = query.integer(7);
  record.undone_by = query.text(8);
  record.excluded = rows_kept_out(session, stored.id);
  return stored;
}

}  // namespace

std::string numbers_text(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (const std::int64_t number : numbers)
    text += (text.empty() ? "" : " ") + std::to_string(number);
  return text;
}

std::vector<std::int64_t> numbers_from(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::int64_t> numbers;
  for (std::int64_t number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

void throw_no_such_diagnosis(Session& session, DiagnosisId id) {
  throw_failure(ErrorCode::not_found, reasons::kNoSuchDiagnosis,
                "there is no diagnosis " + std::to_string(id.value) + " in database " +
                    session.db.path() + ": 'driftwise diagnosis list' shows those there are");
}

void require_diagnosis(Session& session, DiagnosisId id) {
  Query query(session.db, "SELECT 1 FROM diagnosis WHERE diagnosis_id = ?");
  if (!query.bind(id).row()) throw_no_such_diagnosis(session, id);
}

ExtensionRecord insert_extension(Session& session, const NewExtension& extension) {
  require_diagnosis(session, extension.diagnosis);
  if (const auto last = last_extension(session, extension.diagnosis); last && last->record.stands())
    throw_failure(ErrorCode::already_exists, reasons::kExtensionStands,
                  "diagnosis " + std::to_string(extension.diagnosis.value) + " was accepted by " +
                      last->record.accepted_by +
                      " and stands: undo it first to accept other findings");
  std::optional<CorrectionId> correction;
  if (!extension.correction_json.empty()) {
    Query(session.db,
          "INSERT INTO correction (diagnosis_id, json, created_ns, created_by, ended_ns, ended_by) "
          "VALUES (?, ?, ?, ?, 0, '')")
        .bind(extension.diagnosis, extension.correction_json, extension.at.utc.utc_ns,
              extension.who)
        .run();
    correction = CorrectionId{session.db.last_row_id()};
    insert_changes(session, *correction, extension.changes);
  }
  auto model = extension.model;
  if (extension.fitted) {
    auto fitted = *extension.fitted;
    if (correction && extension.rests_on_this) fitted.corrections.push_back(*correction);
    model = insert_model(session, fitted);
    if (extension.promoted)
      insert_promotion(session, {model, extension.at.utc, extension.who, "promote"});
  }
  std::vector<std::int64_t> findings(extension.findings.begin(), extension.findings.end());
  Query(session.db,
        "INSERT INTO extension (diagnosis_id, findings, model_id, promoted, correction_id, "
        "accepted_ns, accepted_by, undone_ns, undone_by) VALUES (?, ?, ?, ?, ?, ?, ?, 0, '')")
      .bind(extension.diagnosis, numbers_text(findings), model, extension.promoted ? 1 : 0,
            correction, extension.at.utc.utc_ns, extension.who)
      .run();
  const std::int64_t id = session.db.last_row_id();
  for (auto exclusion : extension.exclusions) {
    exclusion.at = extension.at;
    exclusion.who = extension.who;
    exclusion.from = extension.from;
    const auto stored = store_exclusion(session, exclusion);
    if (stored.id != 0) keep_out(session, id, stored);
    // Of those that were out before, a person's are not ours to put back; another extension's stay
    // out until both are undone.
    const auto others = rows_of_others(session, id, exclusion.run);
    std::erase_if(exclusion.rows, [&](std::int64_t row) {
      return !others.contains(row) || std::ranges::find(stored.rows, row) != stored.rows.end();
    });
    if (!exclusion.rows.empty()) keep_out(session, id, insert_exclusion(session, exclusion));
  }
  return last_extension(session, extension.diagnosis)->record;
}

ExtensionRecord undo_extension_row(Session& session, DiagnosisId id, const Stamp& at,
                                   const std::string& who, const std::string& from,
                                   const std::optional<PromotionRecord>& rollback) {
  require_diagnosis(session, id);
  const auto last = last_extension(session, id);
  if (!last || !last->record.stands())
    throw_failure(ErrorCode::failed_precondition, reasons::kNoExtension,
                  "nothing of diagnosis " + std::to_string(id.value) +
                      (last ? " stands any more" : " was accepted") + ": there is nothing to undo");
  if (rollback) insert_promotion(session, *rollback);
  Query(session.db, "UPDATE extension SET undone_ns = ?, undone_by = ? WHERE extension_id = ?")
      .bind(at.utc.utc_ns, who, last->id)
      .run();
  if (last->record.correction)
    Query(session.db,
          "UPDATE correction SET ended_ns = ?, ended_by = ? WHERE correction_id = ? AND "
          "ended_ns = 0")
        .bind(at.utc.utc_ns, who, *last->record.correction)
        .run();
  for (auto kept : last->record.excluded) {
    const auto others = rows_of_others(session, last->id, kept.run);
    std::erase_if(kept.rows, [&](std::int64_t row) { return others.contains(row); });
    store_exclusion(session,
                    {0, kept.run, false, kept.rows,
                     "diagnosis " + std::to_string(id.value) + " was undone", at, who, from});
  }
  return last_extension(session, id)->record;
}

std::optional<ExtensionRecord> read_extension(Session& session, DiagnosisId id) {
  auto last = last_extension(session, id);
  if (!last) return std::nullopt;
  return std::move(last->record);
}

std::vector<CorrectionRecord> read_corrections(Session& session) {
  Query query(
      session.db,
      "SELECT correction_id, diagnosis_id, json, created_ns, created_by, ended_ns, ended_by "
      "FROM correction ORDER BY correction_id");
  std::vector<CorrectionRecord> corrections;
  while (query.row()) {
    CorrectionRecord record;
    record.id = {query.integer(0)};
    if (const auto diagnosis = query.optional_integer(1))
      record.diagnosis = DiagnosisId{*diagnosis};
    record.json = query.text(2);
    record.created.utc_ns = query.integer(3);
    record.created_by = query.text(4);
    record.ended.utc_ns = query.integer(5);
    record.ended_by = query.text(6);
    corrections.push_back(std::move(record));
  }
  for (auto& record : corrections) record.changes = read_changes(session, record.id);
  return corrections;
}

}  // namespace driftwise::storage
