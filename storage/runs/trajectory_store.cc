#include "storage/runs/trajectory_store.h"

#include "server/core/reasons.h"

namespace driftwise::storage {
namespace {

KeptTrajectory trajectory_from(const Query& row) {
  return {{row.integer(0)}, row.text(1),      row.text(2), row.text(3),
          row.integer(4),   {row.integer(5)}, row.text(6)};
}

}  // namespace

Result<KeptTrajectory> SqliteTrajectoryStore::keep(const KeptTrajectory& trajectory) {
  return session_.write([&] {
    Query(session_.db,
          "INSERT OR IGNORE INTO trajectory (name, text, hash, row_count, created_ns, created_by) "
          "SELECT ?1, ?2, ?3, ?4, ?5, ?6 WHERE NOT EXISTS (SELECT 1 FROM trajectory WHERE text = "
          "?2)")
        .bind(trajectory.name, trajectory.text, trajectory.hash, trajectory.rows,
              trajectory.created.utc_ns, trajectory.created_by)
        .run();
    Query query(session_.db,
                "SELECT trajectory_id, name, text, hash, row_count, created_ns, created_by FROM "
                "trajectory WHERE text = ?");
    query.bind(trajectory.text).row();
    return trajectory_from(query);
  });
}

Result<KeptTrajectory> SqliteTrajectoryStore::trajectory(TrajectoryId id) {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT trajectory_id, name, text, hash, row_count, created_ns, created_by FROM "
                "trajectory WHERE trajectory_id = ?");
    if (!query.bind(id).row())
      throw_failure(ErrorCode::not_found, reasons::kNoSuchTrajectory,
                    "there is no trajectory " + std::to_string(id.value) +
                        ": 'driftwise trajectory list' shows those there are");
    return trajectory_from(query);
  });
}

Result<std::vector<KeptTrajectory>> SqliteTrajectoryStore::trajectories() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT trajectory_id, name, '', hash, row_count, created_ns, created_by FROM "
                "trajectory ORDER BY trajectory_id DESC");
    std::vector<KeptTrajectory> all;
    while (query.row()) all.push_back(trajectory_from(query));
    return all;
  });
}

}  // namespace driftwise::storage
