#pragma once
// Rows of improvement and its turns. Each call runs inside the caller's transaction and throws
// StorageFailure.

#include <vector>

#include "server/core/records/diagnosis_records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

ImprovementRecord insert_improvement(Session& session, const ImprovementRecord& improvement);
void put_turn_row(Session& session, ImprovementId id, const ImprovementTurn& turn);
void end_improvement_row(Session& session, ImprovementId id, JobState state,
                         const std::string& reason, CellTime at);
ImprovementRecord read_improvement(Session& session, ImprovementId id);
std::vector<ImprovementRecord> read_improvements(Session& session, int limit);

}  // namespace driftwise::storage
