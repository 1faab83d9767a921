#pragma once
// The procedure's facts, gathered from the record and the cell as it is now. Executor's thread.

#include <vector>

#include "server/application/cell/services.h"
#include "server/application/procedure/procedure_steps.h"
#include "server/application/status/cell_status.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// Kinds of sources of inaccuracy (table 4.1 of the study), and the channels of this cell that
// measure each. values: of the cell now, which have what an instrument reads beside its length.
std::vector<ProcedureSource> sources_of(const CellDescription& cell,
                                        const std::vector<LatestValue>& values);

// Newest first: what the runs are, and the newest statement of a wanted accuracy. Runs whose rows
// are a file's are none of this cell's procedure.
void take_runs(const std::vector<RunRecord>& newest_first, ProcedureFacts& facts);

class Procedures {
 public:
  // cell: borrowed, outlives this.
  explicit Procedures(const Services& cell) : cell_(cell) {}

  // Errors: those of the store.
  Awaitable<Result<std::vector<ProcedureStep>>> steps();

 private:
  Awaitable<Result<void>> look_at_model(ProcedureFacts& facts);
  Awaitable<void> look_at_verification(ProcedureFacts& facts);

  Services cell_;
};

}  // namespace driftwise::application
