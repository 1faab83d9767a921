#pragma once
// One answer out of a database, with the sqlite3 library alone: what any outside program would see.

#include <cstdint>
#include <string>

namespace driftwise::tests {

// The first column of the first row as text; "" for NULL and when there is no row. Throws
// std::runtime_error with SQLite's words.
std::string query_one(const std::string& database, const std::string& sql);
std::int64_t count_of(const std::string& database, const std::string& sql);

}  // namespace driftwise::tests
