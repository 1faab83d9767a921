#include "storage/rows/reading_rows.h"

#include <algorithm>

namespace driftwise::storage {

void insert_readings(Session& session, std::span<const Reading> readings,
                     std::optional<std::int64_t> attempt_id) {
  if (readings.empty()) return;
  Query reading_row(session.db,
                    "INSERT INTO reading (device_id, start_ns, end_ns, sequence, attempt_id) "
                    "VALUES (?, ?, ?, ?, ?)");
  // A channel named twice in one reading: the first value stands, as Reading::find has it.
  Query value_row(
      session.db,
      "INSERT OR IGNORE INTO reading_value (reading_id, channel_id, value) VALUES (?, ?, ?)");
  for (const Reading& reading : readings) {
    reading_row
        .bind(session.names.device(reading.device), reading.start.utc_ns, reading.end.utc_ns,
              reading.sequence, attempt_id)
        .run();
    const std::int64_t id = session.db.last_row_id();
    for (const ChannelValue& value : reading.values)
      value_row.bind(id, session.names.channel(value.channel, Names::Use::reading), value.value)
          .run();
  }
}

void insert_rejected(Session& session, std::span<const RejectedAnswer> rejected) {
  if (rejected.empty()) return;
  Query row(session.db,
            "INSERT OR IGNORE INTO rejected_value (device_id, start_ns, sequence, channel_id, "
            "test, reason) VALUES (?, ?, ?, ?, ?, ?)");
  for (const RejectedAnswer& one : rejected)
    row.bind(session.names.device(one.device), one.start.utc_ns, one.sequence,
             session.names.channel(one.value.channel, Names::Use::reading), one.value.test,
             one.value.reason)
        .run();
}

void insert_moves(Session& session, std::span<const MoveRecord> moves) {
  if (moves.empty()) return;
  Query next(session.db, "SELECT coalesce(max(ordinal) + 1, 0) FROM move WHERE at_ns = ?");
  Query row(
      session.db,
      "INSERT INTO move (at_ns, ordinal, axis, at_monotonic_ns, run_id, from_mm, to_mm, cause) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  for (const MoveRecord& move : moves) {
    next.bind(move.at.utc.utc_ns).row();
    const std::int64_t ordinal = next.integer(0);
    next.restart();
    const std::size_t axes = std::max(move.from_mm.size(), move.to_mm.size());
    for (std::size_t axis = axes == 0 ? 0 : 1; axis <= axes; ++axis) {
      const auto at = [axis](const std::vector<double>& mm) {
        return axis >= 1 && axis <= mm.size() ? std::optional(mm[axis - 1]) : std::nullopt;
      };
      row.bind(move.at.utc.utc_ns, ordinal, static_cast<std::int64_t>(axis), move.at.monotonic_ns,
               move.run, at(move.from_mm), at(move.to_mm), move.cause)
          .run();
    }
  }
}

}  // namespace driftwise::storage
