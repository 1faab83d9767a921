#pragma once

#include "server/core/ports/store.h"
#include "storage/session.h"

namespace driftwise::storage {

class SqliteEventStore final : public EventStore {
 public:
  explicit SqliteEventStore(Session& session) : session_(session) {}
  Result<EventId> add_event(const EventRecord& event) override;
  Result<std::vector<EventRecord>> events(EventId after, int limit) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
