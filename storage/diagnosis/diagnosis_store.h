#pragma once
// Diagnoses, extensions, corrections and improvements (storage/schema/schema_v3.h). Thread: the
// session's.

#include "server/core/ports/diagnosis_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteDiagnosisStore final : public DiagnosisStore {
 public:
  explicit SqliteDiagnosisStore(Session& session) : session_(session) {}

  Result<DiagnosisRecord> add_diagnosis(const DiagnosisRecord& diagnosis) override;
  Result<void> end_diagnosis(DiagnosisId id, const DiagnosisEnd& end) override;
  Result<DiagnosisRecord> diagnosis(DiagnosisId id) override;
  Result<std::vector<DiagnosisRecord>> diagnoses(int limit) override;
  Result<std::string> diagnosis_rows(DiagnosisId id) override;
  Result<std::int64_t> fail_unfinished(const std::string& reason, CellTime at) override;

 private:
  Session& session_;
};

class SqliteExtensionStore final : public ExtensionStore {
 public:
  explicit SqliteExtensionStore(Session& session) : session_(session) {}

  Result<ExtensionRecord> accept(const NewExtension& extension) override;
  Result<ExtensionRecord> undo_extension(DiagnosisId id, const Stamp& at, const std::string& who,
                                         const std::string& from,
                                         const std::optional<PromotionRecord>& rollback) override;
  Result<std::optional<ExtensionRecord>> extension(DiagnosisId id) override;
  Result<std::vector<CorrectionRecord>> corrections() override;

 private:
  Session& session_;
};

class SqliteImprovementStore final : public ImprovementStore {
 public:
  explicit SqliteImprovementStore(Session& session) : session_(session) {}

  Result<ImprovementRecord> add_improvement(const ImprovementRecord& improvement) override;
  Result<void> put_turn(ImprovementId id, const ImprovementTurn& turn) override;
  Result<void> end_improvement(ImprovementId id, JobState state, const std::string& reason,
                               CellTime at) override;
  Result<ImprovementRecord> improvement(ImprovementId id) override;
  Result<std::vector<ImprovementRecord>> improvements(int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
