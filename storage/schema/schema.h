#pragma once
// Brings a database to the present version of the schema: PRAGMA user_version says which one it
// has.

#include <span>
#include <string>
#include <string_view>

#include "storage/sqlite/database.h"

namespace driftwise::storage {

// PRAGMA application_id of every Driftwise database: "DWDB". A file of somebody else is refused,
// not extended.
constexpr std::int64_t kApplicationId = 0x44574442;

// migrations[n] takes a database from version n to n + 1.
std::span<const std::string_view> migrations();
constexpr std::int64_t kChainVersion = 7;  // from here on a database has a chain
inline int schema_version() { return static_cast<int>(migrations().size()); }

// Looks only: a file of somebody else, or of a later program, must not even be switched to WAL.
// Errors: failed_precondition SCHEMA_NEWER, NOT_DRIFTWISE (has other tables).
void refuse_foreign_or_newer(Database& db, int newest = schema_version());

// Runs what is missing, each version in one transaction with its user_version, so that a crash
// leaves one of them. Errors: as above.
void migrate(Database& db, std::span<const std::string_view> steps = migrations());

// For a read-only connection, which cannot migrate: also SCHEMA_OLDER.
void require_present_schema(Database& db);

}  // namespace driftwise::storage
