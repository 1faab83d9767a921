#include "storage/watch/stop_store.h"

namespace driftwise::storage {

std::vector<StopRecord> SqliteStopStore::read_pending() {
  Query query(session_.db,
              "SELECT stop_id, controller, who, from_peer, cause, asked_ns, asked_monotonic_ns, "
              "presses FROM stop WHERE confirmed_ns = 0 ORDER BY stop_id");
  std::vector<StopRecord> stops;
  while (query.row()) {
    StopRecord stop;
    stop.id = {query.integer(0)};
    stop.controller = query.text(1);
    stop.who = query.text(2);
    stop.from = query.text(3);
    stop.cause = query.text(4);
    stop.asked = {{query.integer(5)}, query.integer(6)};
    stop.presses = query.integer(7);
    stop.held_by = stop.who;
    stop.held_at = stop.asked.utc;
    stops.push_back(std::move(stop));
  }
  return stops;
}

// A restart must find the run paused even when the daemon is killed before the run's own coroutine
// has seen the stop. The newest run that is queued is about to begin: a restart would begin it.
void SqliteStopStore::pause_run(const StopRecord& stop) {
  Query(session_.db,
        "UPDATE run_progress SET state = 'paused', reason = ?, hold_kind = 'stop', hold_who = ?, "
        "hold_ns = ? WHERE state IN ('running', 'waiting') OR (state = 'queued' AND run_id = "
        "(SELECT max(run_id) FROM run_progress))")
      .bind(stop.cause, stop.held_by, stop.held_at.utc_ns)
      .run();
}

// Likewise the queue: nothing that waits may begin by itself after a stop.
void SqliteStopStore::hold_queue(const StopRecord& stop) {
  Query(session_.db,
        "INSERT INTO queue_hold (one, held, who, why, at_ns) VALUES (1, 1, ?, ?, ?) ON CONFLICT "
        "(one) DO UPDATE SET held = 1, who = excluded.who, why = excluded.why, at_ns = "
        "excluded.at_ns WHERE held = 0")
      .bind(stop.who, stop.cause, stop.asked.utc.utc_ns)
      .run();
}

Result<std::vector<StopRecord>> SqliteStopStore::keep(std::span<const StopRecord> stops) {
  return session_.write([&] {
    for (const auto& stop : stops)
      Query(session_.db,
            "INSERT INTO stop (controller, who, from_peer, cause, asked_ns, asked_monotonic_ns, "
            "presses, confirmed_ns) VALUES (?, ?, ?, ?, ?, ?, ?, 0) ON CONFLICT (controller) WHERE "
            "confirmed_ns = 0 DO UPDATE SET cause = excluded.cause, presses = excluded.presses")
          .bind(stop.controller, stop.who, stop.from, stop.cause, stop.asked.utc.utc_ns,
                stop.asked.monotonic_ns, stop.presses)
          .run();
    if (!stops.empty()) {
      pause_run(stops.front());
      hold_queue(stops.front());
    }
    return read_pending();
  });
}

Result<bool> SqliteStopStore::confirm(const StopRecord& stop, CellTime at) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE stop SET confirmed_ns = ?3 WHERE controller = ?1 AND presses = ?2 AND "
          "confirmed_ns = 0")
        .bind(stop.controller, stop.presses, at.utc_ns)
        .run();
    const bool ended = session_.db.changed_rows() > 0;
    if (ended) pause_run(stop);
    return ended;
  });
}

Result<std::vector<StopRecord>> SqliteStopStore::pending() {
  return session_.read([&] { return read_pending(); });
}

}  // namespace driftwise::storage
