#include "storage/diagnosis/job_changes.h"

#include <algorithm>
#include <set>

namespace driftwise::storage {
namespace {

JobState job_state_in(const Query& row, int column) {
  return job_state_from(row.text(column)).value_or(JobState::failed);
}

DiagnosisChange read_diagnosis_change(Session& session, DiagnosisId id) {
  Query query(session.db, "SELECT state, reason FROM diagnosis WHERE diagnosis_id = ?");
  query.bind(id).row();
  return {id, job_state_in(query, 0), query.text(1)};
}

ImprovementChange read_improvement_change(Session& session, ImprovementId id) {
  Query query(session.db,
              "SELECT state, reason, (SELECT count(*) FROM improvement_turn WHERE improvement_id = "
              "?1) FROM improvement WHERE improvement_id = ?1");
  query.bind(id).row();
  return {id, job_state_in(query, 0), query.text(1), static_cast<int>(query.integer(2))};
}

}  // namespace

std::int64_t newest_job_change(Session& session) {
  Query query(session.db, "SELECT coalesce(max(change), 0) FROM job_change");
  query.row();
  return query.integer(0);
}

void read_job_changes(Session& session, const RecordCursor& after, const RecordCursor& until,
                      int limit, RecordPage& page) {
  Query query(session.db,
              "SELECT change, diagnosis_id, improvement_id FROM job_change WHERE change > ? AND "
              "change <= ? ORDER BY change LIMIT ?");
  query.bind(after.job, until.job, limit);
  std::set<DiagnosisId> diagnoses;
  std::set<ImprovementId> improvements;
  std::int64_t last = after.job;
  int count = 0;
  for (; query.row(); ++count) {
    last = query.integer(0);
    if (const auto id = query.optional_integer(1)) diagnoses.insert(DiagnosisId{*id});
    if (const auto id = query.optional_integer(2)) improvements.insert(ImprovementId{*id});
  }
  for (const DiagnosisId id : diagnoses)
    page.diagnoses.push_back(read_diagnosis_change(session, id));
  for (const ImprovementId id : improvements)
    page.improvements.push_back(read_improvement_change(session, id));
  page.to.job = count < limit ? std::max(after.job, until.job) : last;
}

}  // namespace driftwise::storage
