#pragma once
// Rows of reading, reading_value and move. Inside the caller's write transaction; throws
// StorageFailure.

#include <optional>
#include <span>

#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

void insert_readings(Session& session, std::span<const Reading> readings,
                     std::optional<std::int64_t> attempt_id);
// Beside their readings, which are on record or on their way there.
void insert_rejected(Session& session, std::span<const RejectedAnswer> rejected);
void insert_moves(Session& session, std::span<const MoveRecord> moves);

}  // namespace driftwise::storage
