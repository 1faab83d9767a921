#include "storage/watch/event_store.h"

#include <limits>

namespace driftwise::storage {

std::vector<EventRecord> read_events(Session& session, std::int64_t after, std::int64_t until,
                                     int limit) {
  Query query(session.db,
              "SELECT event_id, at_ns, at_monotonic_ns, who, peer, what, detail, run_id FROM event "
              "WHERE event_id > ? AND event_id <= ? ORDER BY event_id LIMIT ?");
  query.bind(after, until, limit);
  std::vector<EventRecord> events;
  while (query.row()) {
    EventRecord event{{query.integer(0)},
                      {{query.integer(1)}, query.integer(2)},
                      query.text(3),
                      query.text(4),
                      query.text(5),
                      query.text(6),
                      {}};
    if (const auto run = query.optional_integer(7)) event.run = RunId{*run};
    events.push_back(std::move(event));
  }
  return events;
}

EventId insert_event(Session& session, const EventRecord& event) {
  Query(session.db,
        "INSERT INTO event (at_ns, at_monotonic_ns, who, peer, what, detail, run_id) VALUES (?, "
        "?, ?, ?, ?, ?, ?)")
      .bind(event.at.utc.utc_ns, event.at.monotonic_ns, event.who, event.from, event.what,
            event.detail, event.run)
      .run();
  return EventId{session.db.last_row_id()};
}

Result<EventId> SqliteEventStore::add_event(const EventRecord& event) {
  return session_.write([&] { return insert_event(session_, event); });
}

Result<std::vector<EventRecord>> SqliteEventStore::events(EventId after, int limit) {
  return session_.read([&] {
    return read_events(session_, after.value, std::numeric_limits<std::int64_t>::max(),
                       limit > 0 ? limit : -1);
  });
}

}  // namespace driftwise::storage
