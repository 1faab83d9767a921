#pragma once
// A database that takes everything but ends of diagnoses and improvements, while its disk is full.

#include <memory>
#include <optional>

#include "server/core/ports/store.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {

struct Refusals {
  std::optional<Error> of_ends;  // what an end is answered; none: it is stored
  int ends = 0;                  // that were asked for
  int looks = 0;                 // at diagnoses
};

class FullForEnds final : public Store, DiagnosisStore, ImprovementStore {
 public:
  FullForEnds(std::unique_ptr<Store> inner, Refusals& refusals)
      : Store(before(*inner, this)), inner_(std::move(inner)), refusals_(refusals) {}

 private:
  static StoreParts before(Store& inner, FullForEnds* its) {
    StoreParts parts = inner.parts();
    parts.diagnoses = its;
    parts.improvements = its;
    parts.upkeep = nullptr;
    return parts;
  }
  Result<DiagnosisRecord> add_diagnosis(const DiagnosisRecord& diagnosis) override {
    return inner_->diagnoses().add_diagnosis(diagnosis);
  }
  Result<void> end_diagnosis(DiagnosisId id, const DiagnosisEnd& end) override {
    ++refusals_.ends;
    if (refusals_.of_ends) return tl::unexpected(*refusals_.of_ends);
    return inner_->diagnoses().end_diagnosis(id, end);
  }
  Result<DiagnosisRecord> diagnosis(DiagnosisId id) override {
    ++refusals_.looks;
    return inner_->diagnoses().diagnosis(id);
  }
  Result<std::vector<DiagnosisRecord>> diagnoses(int limit) override {
    return inner_->diagnoses().diagnoses(limit);
  }
  Result<std::string> diagnosis_rows(DiagnosisId id) override {
    return inner_->diagnoses().diagnosis_rows(id);
  }
  Result<std::int64_t> fail_unfinished(const std::string& reason, CellTime at) override {
    return inner_->diagnoses().fail_unfinished(reason, at);
  }
  Result<ImprovementRecord> add_improvement(const ImprovementRecord& improvement) override {
    return inner_->improvements().add_improvement(improvement);
  }
  Result<void> put_turn(ImprovementId id, const ImprovementTurn& turn) override {
    return inner_->improvements().put_turn(id, turn);
  }
  Result<void> end_improvement(ImprovementId id, JobState state, const std::string& reason,
                               CellTime at) override {
    ++refusals_.ends;
    if (refusals_.of_ends) return tl::unexpected(*refusals_.of_ends);
    return inner_->improvements().end_improvement(id, state, reason, at);
  }
  Result<ImprovementRecord> improvement(ImprovementId id) override {
    return inner_->improvements().improvement(id);
  }
  Result<std::vector<ImprovementRecord>> improvements(int limit) override {
    return inner_->improvements().improvements(limit);
  }
  Result<void> idle() override { return inner_->idle(); }

  std::unique_ptr<Store> inner_;
  Refusals& refusals_;
};

// Of the real store, for a cell in memory; the refusals outlive it.
inline OpenStore full_for_ends(Refusals& refusals) {
  return [&refusals](const std::string& path, bool read_only) -> Result<std::unique_ptr<Store>> {
    auto store = kSqlite(path, read_only);
    if (!store) return store;
    return std::unique_ptr<Store>(new FullForEnds(std::move(*store), refusals));
  };
}

inline Error disk_full() {
  return {ErrorCode::resource_exhausted, "DISK_FULL", "the disk is full: make room"};
}

}  // namespace driftwise::tests
