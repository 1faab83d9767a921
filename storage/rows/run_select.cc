#include "storage/rows/run_select.h"

#include "server/core/reasons.h"
#include "storage/rows/place_text.h"
#include "storage/sqlite/failure.h"

namespace driftwise::storage {

RunRecord run_from(const Query& row, const std::string& file) {
  RunRecord run;
  run.id = {row.integer(0)};
  run.name = row.text(1);
  run.trajectory_name = row.text(2);
  run.trajectory_text = row.text(3);
  run.rows = row.integer(4);
  run.rules_json = row.text(5);
  run.config_hash = row.text(6);
  run.operator_name = row.text(7);
  run.request_id = row.text(8);
  const auto state = run_state_from(row.text(9));
  run.reason = row.text(10);
  run.created = {row.integer(11)};
  run.started = {row.integer(12)};
  run.ended = {row.integer(13)};
  run.place.next_row = row.integer(14);
  auto requeued = requeued_from(row.text(15));
  if (!state || !requeued)
    throw_failure(
        ErrorCode::data_loss, reasons::kDatabaseDamaged,
        "database " + file + ": run_progress of run " + std::to_string(run.id.value) +
            " has state '" + row.text(9) + "' and requeued '" + row.text(15) +
            "', expected a run state and \"row:count row:count\": restore what was edited");
  run.state = *state;
  run.place.requeued = std::move(*requeued);
  run.accepted = row.integer(16);
  run.given_up = row.integer(17);
  run.attempts = row.integer(18);
  run.restarts = row.integer(19);
  run.max_lag_s = row.real(20);
  run.hold.kind = hold_kind_from(row.text(21)).value_or(RunHold::Kind::none);
  run.hold.who = row.text(22);
  run.hold.at = {row.integer(23)};
  if (run.hold.kind != RunHold::Kind::none) run.hold.reason = run.reason;
  run.boot_id = row.text(24);
  run.metadata = metadata_from_lines(row.text(25));
  if (const auto entry = row.optional_integer(26)) run.queue_entry = QueueEntryId{*entry};
  return run;
}

}  // namespace driftwise::storage
