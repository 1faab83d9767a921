#pragma once

#include "server/core/ports/clock_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteClockStore final : public ClockStore {
 public:
  explicit SqliteClockStore(Session& session) : session_(session) {}
  Result<void> add_clock(const ClockRecord& record) override;
  Result<std::vector<ClockRecord>> clocks() override;
  Result<CellTime> newest_instant() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
