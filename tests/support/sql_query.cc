#include "tests/support/sql_query.h"

#include <sqlite3.h>

#include <stdexcept>

namespace driftwise::tests {

std::string query_one(const std::string& database, const std::string& sql) {
  sqlite3* db = nullptr;
  sqlite3_stmt* statement = nullptr;
  int code = sqlite3_open_v2(database.c_str(), &db, SQLITE_OPEN_READWRITE, nullptr);
  if (code == SQLITE_OK) code = sqlite3_busy_timeout(db, 5000);
  if (code == SQLITE_OK) code = sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr);
  if (code == SQLITE_OK) code = sqlite3_step(statement);
  std::string answer;
  if (code == SQLITE_ROW)
    if (const auto* text = sqlite3_column_text(statement, 0))
      answer = reinterpret_cast<const char*>(text);
  const std::string trouble = sqlite3_errmsg(db);
  sqlite3_finalize(statement);
  sqlite3_close(db);
  if (code != SQLITE_ROW && code != SQLITE_DONE)
    throw std::runtime_error(database + ": " + sql + ": " + trouble);
  return answer;
}

std::int64_t count_of(const std::string& database, const std::string& sql) {
  return std::stoll(query_one(database, sql));
}

}  // namespace driftwise::tests
