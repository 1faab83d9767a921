#pragma once
// The views that show one column per channel: point_wide and reading_wide. A look-up per column,
// not a pivot, so that a WHERE on time or run uses the tables' indices.

#include "storage/sqlite/database.h"

namespace driftwise::storage {

// Inside a write transaction. Channels in the order in which they first appeared.
void rebuild_point_wide(Database& db);
void rebuild_reading_wide(Database& db);

}  // namespace driftwise::storage
