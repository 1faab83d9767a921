#pragma once

#include "server/core/ports/store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Inside the caller's transaction: those after one id and up to another, at most limit (-1: all).
std::vector<EventRecord> read_events(Session& session, std::int64_t after, std::int64_t until,
                                     int limit);

EventId insert_event(Session& session, const EventRecord& event);

class SqliteEventStore final : public EventStore {
 public:
  explicit SqliteEventStore(Session& session) : session_(session) {}
  Result<EventId> add_event(const EventRecord& event) override;
  Result<std::vector<EventRecord>> events(EventId after, int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
