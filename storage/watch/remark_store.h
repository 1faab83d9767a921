#pragma once
// Exclusions and notes (storage/schema/schema_v2.h). Thread: the session's.

#include <cstdint>
#include <map>

#include "server/core/ports/store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

struct ExcludedRow {
  bool suspect = false;
};
// Rows of a run's trajectory that are out now. Inside the caller's transaction.
std::map<std::int64_t, ExcludedRow> excluded_rows(Session& session, RunId run);

// Inside the caller's write transaction: as RemarkStore::exclude.
ExclusionRecord store_exclusion(Session& session, const ExclusionRecord& exclusion);
// The record as it is, also of rows that are out (or in) already: a second reason for them.
ExclusionRecord insert_exclusion(Session& session, const ExclusionRecord& exclusion);

class SqliteRemarkStore final : public RemarkStore {
 public:
  explicit SqliteRemarkStore(Session& session) : session_(session) {}

  Result<ExclusionRecord> exclude(const ExclusionRecord& exclusion) override;
  Result<std::vector<ExclusionRecord>> exclusions(RunId run) override;
  Result<NoteRecord> add_note(const NoteRecord& note) override;
  Result<std::vector<NoteRecord>> notes(const NoteSubject& subject) override;
  Result<TimeNoteRecord> add_time_note(const TimeNoteRecord& note) override;
  Result<std::vector<TimeNoteRecord>> time_notes(CellTime from, CellTime to, int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
