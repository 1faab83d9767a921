#pragma once
// Diagnoses, what was made of them, and the loops that ran them: parts of
// server/core/ports/store.h, with its thread and its errors.

#include <optional>
#include <string>
#include <vector>

#include "server/core/records/diagnosis_records.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise {

class DiagnosisStore {
 public:
  virtual ~DiagnosisStore() = default;
  // Its id, end and result are ignored: it is running. Errors: not_found NO_SUCH_RUN,
  // NO_SUCH_MODEL.
  virtual Result<DiagnosisRecord> add_diagnosis(const DiagnosisRecord& diagnosis) = 0;
  // Errors: failed_precondition ALREADY_OVER: the first end stands.
  virtual Result<void> end_diagnosis(DiagnosisId id, const DiagnosisEnd& end) = 0;
  virtual Result<DiagnosisRecord> diagnosis(DiagnosisId id) = 0;  // not_found NO_SUCH_DIAGNOSIS
  virtual Result<std::vector<DiagnosisRecord>> diagnoses(int limit) = 0;  // newest first
  virtual Result<std::string> diagnosis_rows(DiagnosisId id) = 0;  // as ended with; empty: none
  // Diagnoses and improvements that ran when the daemon ended have failed: called once, at the
  // start. Result: how many.
  virtual Result<std::int64_t> fail_unfinished(const std::string& reason, CellTime at) = 0;
};

// Findings that became part of a model.
class ExtensionStore {
 public:
  virtual ~ExtensionStore() = default;
  // In one transaction: the model, its promotion, the exclusions and the correction take effect
  // with the extension or not at all. Errors: already_exists EXTENSION_STANDS (undo it first),
  // those of exclude().
  virtual Result<ExtensionRecord> accept(const NewExtension& extension) = 0;
  // Ends what stands: its correction, its exclusions, and with `rollback` that its model serves; in
  // one transaction. Errors: failed_precondition NO_EXTENSION.
  virtual Result<ExtensionRecord> undo_extension(
      DiagnosisId id, const Stamp& at, const std::string& who, const std::string& from,
      const std::optional<PromotionRecord>& rollback = {}) = 0;
  // The last one that was accepted, undone or not.
  virtual Result<std::optional<ExtensionRecord>> extension(DiagnosisId id) = 0;
  virtual Result<std::vector<CorrectionRecord>> corrections() = 0;  // oldest first, ended ones too
};

// Loops of measuring, diagnosing and extending.
class ImprovementStore {
 public:
  virtual ~ImprovementStore() = default;
  // The same request_id again answers with the first one.
  virtual Result<ImprovementRecord> add_improvement(const ImprovementRecord& improvement) = 0;
  virtual Result<void> put_turn(ImprovementId id, const ImprovementTurn& turn) = 0;  // by number
  virtual Result<void> end_improvement(ImprovementId id, JobState state, const std::string& reason,
                                       CellTime at) = 0;
  virtual Result<ImprovementRecord> improvement(ImprovementId id) = 0;  // NO_SUCH_IMPROVEMENT
  virtual Result<std::vector<ImprovementRecord>> improvements(int limit) = 0;  // newest first
};

}  // namespace driftwise
