#pragma once
// SQLite's C API with owners: a connection, a kept statement, a transaction. No ORM: the SQL stands
// where it is used. Thread: one. Errors: every call throws StorageFailure
// (storage/sqlite/failure.h).

#include <sqlite3.h>

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace driftwise::storage {

class Database {
 public:
  // flags: SQLITE_OPEN_*; vfs: empty for the default one.
  Database(const std::string& path, int flags, const std::string& vfs);

  // Closes this connection and opens the path anew; kept statements are prepared again when they
  // are used. After a failure the object is closed, and the next reopen() tries again.
  void reopen();
  void close();
  bool is_open() const { return handle_ != nullptr; }
  // Throws resource_exhausted DATABASE_CLOSED, as after a reopen() that failed.
  void require_open() const {
    if (!is_open()) refuse_closed();
  }
  [[noreturn]] void refuse_closed() const;

  const std::string& path() const { return path_; }
  sqlite3* handle() const { return handle_.get(); }

  // Runs statements that give no rows.
  void execute(const std::string& sql);
  // The first column of every row, as text, of a statement that is used once.
  void for_each_row(const std::string& sql, const std::function<void(const std::string&)>& take);
  std::int64_t pragma(const std::string& name);  // first column of its first row
  std::int64_t last_row_id() const { return sqlite3_last_insert_rowid(handle()); }
  std::int64_t changed_rows() const { return sqlite3_changes64(handle()); }

  // Throws what the connection's last error means; doing: "storing a point". seen_errno: as a
  // failed statement left it; SQLite keeps none of a COMMIT (sqlite3_system_errno has an earlier
  // call's).
  [[noreturn]] void fail_now(std::string_view doing,
                             std::optional<int> seen_errno = std::nullopt) const;

  // A kept statement. sql is a literal: the text's address is the key.
  sqlite3_stmt* kept(const char* sql);

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };

  void open();

  std::string path_, vfs_;
  int flags_;
  std::unique_ptr<sqlite3, Close> handle_;
  std::unordered_map<const char*, std::unique_ptr<sqlite3_stmt, Finalize>> kept_;
};

struct Bytes {  // bound as a BLOB; empty: NULL
  std::string_view bytes;
};

// One use of a kept statement, reset at the end of its scope. Not for two uses of the same text at
// a time.
//   Query query(db, "SELECT name FROM run WHERE run_id = ?");
//   query.bind(run.value);
//   while (query.row()) use(query.text(0));
class Query {
 public:
  Query(Database& db, const char* sql) : db_(db), statement_(db.kept(sql)) {}
  ~Query() { restart(); }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  // Binds all parameters in order; a NaN and nullopt become NULL.
  template <class... Values>
  Query& bind(const Values&... values) {
    int position = 0;
    (bind_one(++position, values), ...);
    return *this;
  }
  // True while there is a row to look at.
  bool row();
  // To its end; the statement can be bound and run again.
  void run() {
    while (row()) {
    }
    restart();
  }
  void restart() { sqlite3_reset(statement_); }

  int columns() const { return sqlite3_column_count(statement_); }
  bool is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  double real(int column) const;  // NULL: kMissing
  std::string text(int column) const;
  std::string bytes(int column) const;  // of a BLOB; NULL: empty
  std::optional<std::int64_t> optional_integer(int column) const {
    return is_null(column) ? std::nullopt : std::optional(integer(column));
  }

 private:
  void bind_one(int position, std::int64_t value) {
    check(sqlite3_bind_int64(statement_, position, value));
  }
  void bind_one(int position, int value) { bind_one(position, std::int64_t{value}); }
  void bind_one(int position, double value) {
    check(sqlite3_bind_double(statement_, position, value));
  }
  void bind_one(int position, std::string_view value);
  void bind_one(int position, const std::string& value) {
    bind_one(position, std::string_view(value));
  }
  void bind_one(int position, Bytes value);
  void bind_one(int position, const char* value) { bind_one(position, std::string_view(value)); }
  template <class Id>
  requires std::same_as<decltype(Id::value), std::int64_t>  // RunId and its like
  void bind_one(int position, Id id) { bind_one(position, id.value); }
  void bind_one(int position, std::nullopt_t) { check(sqlite3_bind_null(statement_, position)); }
  template <class T>
  void bind_one(int position, const std::optional<T>& value) {
    value ? bind_one(position, *value) : bind_one(position, std::nullopt);
  }
  void check(int code) const {
    if (code != SQLITE_OK) db_.fail_now(sqlite3_sql(statement_));
  }

  Database& db_;
  sqlite3_stmt* statement_;
};

// BEGIN ... COMMIT; rolled back when the scope is left without commit().
class Transaction {
 public:
  enum class Kind { write, read };
  explicit Transaction(Database& db, Kind kind = Kind::write);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& db_;
};

}  // namespace driftwise::storage
