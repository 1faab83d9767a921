#pragma once
// The columns of a RunRecord, in one order for every query that reads runs.

#include "server/core/records/records.h"
#include "storage/sqlite/database.h"

namespace driftwise::storage {

// Hash of the cell file that a run was measured under; '' where its rows are a file's, which this
// cell did not measure. The row has the file that was in force at the import. A join of measured
// runs is imported too, and its rules begin with "joined".
#define DRIFTWISE_CELL_FILE_OF_RUN                                                      \
  "CASE WHEN reason = 'imported' AND rules_json NOT LIKE '{\"joined\":%' THEN '' ELSE " \
  "config_hash END"

#define DRIFTWISE_SELECT_RUN_WITH(trajectory_text)                                             \
  "SELECT run_id, name, trajectory_name, " trajectory_text                                     \
  ", trajectory_rows, rules_json, " DRIFTWISE_CELL_FILE_OF_RUN                                 \
  ", operator_name, request_id, state, reason, created_ns, started_ns, ended_ns, next_row, "   \
  "requeued, "                                                                                 \
  "accepted, given_up, attempts, restarts, max_lag_s, hold_kind, hold_who, hold_ns, boot_id, " \
  "(SELECT group_concat(key || '=' || value, char(10)) FROM (SELECT key, value FROM "          \
  "run_metadata m WHERE m.run_id = run.run_id ORDER BY key)), "                                \
  "(SELECT entry_id FROM queue_run o WHERE o.run_id = run.run_id) FROM run JOIN run_progress " \
  "USING (run_id)"

// One run, with its trajectory's text.
#define DRIFTWISE_SELECT_RUN DRIFTWISE_SELECT_RUN_WITH("trajectory_text")
// Lists leave the text blank: that of a grid has megabytes, and a list hundreds of runs.
#define DRIFTWISE_LIST_RUNS DRIFTWISE_SELECT_RUN_WITH("''")

// Throws data_loss when state or requeued say what no Driftwise wrote.
RunRecord run_from(const Query& row, const std::string& file);

}  // namespace driftwise::storage
