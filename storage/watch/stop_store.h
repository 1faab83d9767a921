#pragma once

#include "server/core/ports/stop_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteStopStore final : public StopStore {
 public:
  explicit SqliteStopStore(Session& session) : session_(session) {}
  Result<std::vector<StopRecord>> keep(std::span<const StopRecord> stops) override;
  Result<bool> confirm(const StopRecord& stop, CellTime at) override;
  Result<std::vector<StopRecord>> pending() override;

 private:
  std::vector<StopRecord> read_pending();
  void pause_run(const StopRecord& stop);
  void hold_queue(const StopRecord& stop);
  Session& session_;
};

}  // namespace driftwise::storage
