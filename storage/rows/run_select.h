#pragma once
// The columns of a RunRecord, in one order for every query that reads runs.

#include "server/core/records/records.h"
#include "storage/sqlite/database.h"

namespace driftwise::storage {

#define DRIFTWISE_SELECT_RUN                                                                   \
  "SELECT run_id, name, trajectory_name, trajectory_text, trajectory_rows, rules_json, "       \
  "config_hash, "                                                                              \
  "operator_name, request_id, state, reason, created_ns, started_ns, ended_ns, next_row, "     \
  "requeued, "                                                                                 \
  "accepted, given_up, attempts, restarts, max_lag_s, hold_kind, hold_who, hold_ns, boot_id, " \
  "(SELECT group_concat(key || '=' || value, char(10)) FROM (SELECT key, value FROM "          \
  "run_metadata m WHERE m.run_id = run.run_id ORDER BY key)), "                                \
  "(SELECT entry_id FROM queue_run o WHERE o.run_id = run.run_id) FROM run JOIN run_progress " \
  "USING (run_id)"

// Throws data_loss when state or requeued say what no Driftwise wrote.
RunRecord run_from(const Query& row, const std::string& file);

}  // namespace driftwise::storage
