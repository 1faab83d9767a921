#include "storage/sqlite/database.h"

#include <cerrno>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "storage/sqlite/failure.h"

namespace driftwise::storage {

Database::Database(const std::string& path, int flags, const std::string& vfs)
    : path_(path), vfs_(vfs), flags_(flags) {
  open();
}

void Database::open() {
  sqlite3* raw = nullptr;
  // NOMUTEX: an object belongs to one thread, SQLite need not lock for it.
  const int code =
      sqlite3_open_v2(path_.c_str(), &raw, flags_ | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE,
                      vfs_.empty() ? nullptr : vfs_.c_str());
  handle_.reset(raw);
  if (code != SQLITE_OK) fail_now("opening");
}

void Database::close() {
  kept_.clear();
  handle_.reset();
}

void Database::reopen() {
  close();
  open();
}

void Database::refuse_closed() const {
  throw_failure(ErrorCode::resource_exhausted, reasons::kDatabaseClosed,
                "database " + path_ +
                    " could not be opened anew, and nothing was read or written: the daemon tries "
                    "it again every few seconds; then the same call succeeds");
}

void Database::for_each_row(const std::string& sql,
                            const std::function<void(const std::string&)>& take) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(handle(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK) fail_now(sql);
  const std::unique_ptr<sqlite3_stmt, Finalize> statement(raw);
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(raw)) == SQLITE_ROW) {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(raw, 0));
    take(text == nullptr ? std::string() : std::string(text));
  }
  if (code != SQLITE_DONE) fail_now(sql);
}

void Database::fail_now(std::string_view doing, std::optional<int> seen_errno) const {
  sqlite3* db = handle();
  const int code = db == nullptr ? SQLITE_NOMEM : sqlite3_extended_errcode(db);
  const int kept_errno = db == nullptr ? 0 : sqlite3_system_errno(db);
  const int system_errno =
      (code & 0xff) == SQLITE_IOERR ? seen_errno.value_or(kept_errno) : kept_errno;
  throw StorageFailure{error_from_sqlite(code, system_errno, path_,
                                         std::string(doing.substr(0, 60)),
                                         db == nullptr ? "no memory" : sqlite3_errmsg(db))};
}

void Database::execute(const std::string& sql) {
  require_open();
  errno = 0;
  if (sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail_now(sql, errno);
}

std::int64_t Database::pragma(const std::string& name) {
  sqlite3_stmt* raw = nullptr;
  const std::string sql = "PRAGMA " + name;
  if (sqlite3_prepare_v2(handle(), sql.c_str(), -1, &raw, nullptr) != SQLITE_OK) fail_now(sql);
  const std::unique_ptr<sqlite3_stmt, Finalize> statement(raw);
  const int code = sqlite3_step(raw);
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail_now(sql);
  return code == SQLITE_ROW ? sqlite3_column_int64(raw, 0) : 0;
}

sqlite3_stmt* Database::kept(const char* sql) {
  require_open();
  auto& slot = kept_[sql];
  if (!slot) {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v3(handle(), sql, -1, SQLITE_PREPARE_PERSISTENT, &raw, nullptr) !=
        SQLITE_OK)
      fail_now(sql);
    slot.reset(raw);
  }
  return slot.get();
}

bool Query::row() {
  errno = 0;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) db_.fail_now(sqlite3_sql(statement_), errno);
  return false;
}

double Query::real(int column) const {
  return is_null(column) ? kMissing : sqlite3_column_double(statement_, column);
}

std::string Query::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::string Query::bytes(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

void Query::bind_one(int position, Bytes value) {
  if (value.bytes.empty()) return bind_one(position, std::nullopt);
  check(sqlite3_bind_blob64(statement_, position, value.bytes.data(), value.bytes.size(),
                            SQLITE_TRANSIENT));
}

void Query::bind_one(int position, std::string_view value) {
  // A null pointer would bind NULL, not the empty text.
  check(sqlite3_bind_text64(statement_, position, value.data() == nullptr ? "" : value.data(),
                            value.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

// IMMEDIATE: the write lock is taken here, where nothing has been done yet, rather than at the
// first INSERT.
Transaction::Transaction(Database& db, Kind kind) : db_(db) {
  Query(db, kind == Kind::write ? "BEGIN IMMEDIATE" : "BEGIN").run();
}

Transaction::~Transaction() {
  // SQLite has rolled back by itself after some errors (a full disk); then there is nothing to end.
  if (sqlite3_get_autocommit(db_.handle()) == 0)
    sqlite3_exec(db_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() { Query(db_, "COMMIT").run(); }

}  // namespace driftwise::storage
