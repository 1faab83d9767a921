#pragma once

#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class ProvenanceService final : public Provenance {
 public:
  ProvenanceService(const CellDescription& description, const Clock& clock, StoreReader& reader)
      : description_(description), clock_(clock), reader_(reader) {}
  Awaitable<Result<std::vector<RunGround>>> grounds_of_runs(std::vector<RunId> runs) override;
  Awaitable<Result<ModelGround>> ground_of_model(ModelId id) override;

 private:
  const CellDescription& description_;
  const Clock& clock_;
  StoreReader& reader_;
};

}  // namespace driftwise::application
