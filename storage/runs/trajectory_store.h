#pragma once

#include "server/core/ports/watch_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteTrajectoryStore final : public TrajectoryStore {
 public:
  explicit SqliteTrajectoryStore(Session& session) : session_(session) {}
  Result<KeptTrajectory> keep(const KeptTrajectory& trajectory) override;
  Result<KeptTrajectory> trajectory(TrajectoryId id) override;
  Result<std::vector<KeptTrajectory>> trajectories() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
