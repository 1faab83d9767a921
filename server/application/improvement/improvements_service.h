#pragma once

#include "server/application/diagnoses/diagnoses_service.h"
#include "server/application/improvement/improvements.h"
#include "server/application/improvement/improver.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/trajectories/trajectories.h"

namespace driftwise::application {

class ImprovementsService final : public Improvements {
 public:
  ImprovementsService(const CellDescription& description, StoreReader& reader,
                      const RightToMove& right, Trajectories& trajectories,
                      DiagnosesService& diagnoses, Improver& improver)
      : description_(description),
        reader_(reader),
        right_(right),
        trajectories_(trajectories),
        diagnoses_(diagnoses),
        improver_(improver) {}

  Awaitable<Result<ImprovementRecord>> create(Caller caller, ImproveRequest request) override;
  Awaitable<Result<ImprovementRecord>> cancel(Caller caller, ImprovementId id) override;
  std::shared_ptr<void> watch(std::function<void(const ImprovementProgress&)> on_change) override;

 private:
  const CellDescription& description_;
  StoreReader& reader_;
  const RightToMove& right_;
  Trajectories& trajectories_;
  DiagnosesService& diagnoses_;
  Improver& improver_;
};

}  // namespace driftwise::application
