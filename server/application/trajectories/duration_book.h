#pragma once
// Durations of this cell's runs: read from the record at the start, and added to by each run that
// ends. Executor's thread.

#include <memory>

#include "server/application/plumbing/store_reader.h"
#include "server/application/trajectories/outlook.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class DurationBook {
 public:
  explicit DurationBook(StoreReader& reader) : reader_(reader) {}

  // Once. The runs that are over, the newest of them; one that cannot be read is left out.
  Awaitable<void> load();
  void add(RunSteps run);
  // Never null; stays as it is for whoever holds it.
  std::shared_ptr<const DurationHistory> history() const { return history_; }
  Outlook look_ahead(const RunAhead& ahead) const {
    return application::look_ahead(*history_, ahead);
  }

 private:
  StoreReader& reader_;
  std::shared_ptr<const DurationHistory> history_ = std::make_shared<DurationHistory>();
};

// Of a run on record, the daemon's instants of continuing it included. Blocks.
Result<StepMeter> recorded_meter(Store& store, const RunRecord& run, const PlanLength& plan,
                                 double unit_s);

}  // namespace driftwise::application
