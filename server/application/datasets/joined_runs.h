#pragma once
// Runs of the record as parts of a join, and the join as a dataset of the record.

#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"
#include "server/correction/dataset_join.h"

namespace driftwise::application {

// As they were measured, with the corrections that name single runs; those of the whole cell are
// laid over the joined run as over any other. present: the cell file in force. Called on the
// store's thread. Errors: those of measured_data; failed_precondition RUN_UNDER_WAY.
Result<correction::JoinParts> join_parts(Store& store, const std::vector<RunId>& runs,
                                         const CellDescription& present);

// Corrections that named single runs and so are in the rows of a joined run, ascending: undoing
// them does not take them out. None: no joined run. Any thread.
std::vector<CorrectionId> corrections_in(const RunRecord& run);

struct JoinedRuns {
  Dataset data;  // with its provenance in the metadata
  std::string report_json;
};

// Names of sets (set_names.h, as a line of the metadata) are those of the first part.
// Any thread. Errors: those of correction::join.
Result<JoinedRuns> join_runs(correction::JoinParts parts, const correction::JoinRules& rules,
                             const std::string& cell);

}  // namespace driftwise::application
