#pragma once
// What the parts of one store share: the connection, the names, and how a call begins and ends.

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "server/core/reasons.h"
#include "storage/sqlite/database.h"
#include "storage/sqlite/database_lock.h"
#include "storage/sqlite/failure.h"
#include "storage/sqlite/file_watch.h"
#include "storage/sqlite/names.h"

namespace driftwise::storage {

// What is written within every transaction, right before it is committed.
class AtCommit {
 public:
  virtual ~AtCommit() = default;
  virtual void at_commit() = 0;    // throws StorageFailure: the transaction is rolled back
  virtual void rolled_back() = 0;  // nothing of the transaction is there
  // Readings that this transaction removes as a thinning, ascending; told while they are there.
  // Result: what stands for them, SHA-256 of their digests.
  virtual std::string thin(std::int64_t thinning, std::span<const std::int64_t> readings) = 0;
};

struct Session {
  DatabaseLock lock;  // of a writing session; released after the connection is closed
  Database db;
  Names names;
  bool read_only;
  FileWatch files;  // of a writing session
  AtCommit* at_commit = nullptr;

  // A file that is there is locked before SQLite opens it; a new one, which only SQLite creates,
  // right afterwards and before anything is written. Without a file (":memory:", a simulated disk)
  // there is nothing to lock.
  Session(const std::string& path, int flags, const std::string& vfs, bool reads_only)
      : lock(reads_only ? DatabaseLock() : lock_of_existing(path)),
        db(path, flags, vfs),
        names(db),
        read_only(reads_only) {
    if (!reads_only && !lock.file().exists()) lock = lock_of_existing(path);
  }

  // Runs body in one transaction, durable when this returns; any failure leaves the database as it
  // was.
  template <class F>
  auto write(F&& body) -> Result<std::invoke_result_t<F>> {
    auto result = answered([&]() -> std::invoke_result_t<F> {
      require_writable();
      require_files();
      Transaction transaction(db);
      if constexpr (std::is_void_v<std::invoke_result_t<F>>) {
        body();
        end(transaction);
      } else {
        auto value = body();
        end(transaction);
        return value;
      }
    });
    if (!result) {
      names.forget();
      if (at_commit) at_commit->rolled_back();
    }
    return result;
  }

  // Runs body on one unchanging view of the database.
  template <class F>
  auto read(F&& body) -> Result<std::invoke_result_t<F>> {
    return answered([&] {
      Transaction transaction(db, Transaction::Kind::read);
      auto value = body();
      transaction.commit();
      return value;
    });
  }

  // Moves all of the log into the database and empties it; waits for readers meanwhile. After that
  // nobody needs the log, so that another one may take its place. Throws DATABASE_LOCKED where a
  // reader keeps its view for longer than the busy timeout.
  void secure_log() {
    db.require_open();
    move_log(SQLITE_CHECKPOINT_TRUNCATE);
    files.logged(0);
  }

 private:
  static DatabaseLock lock_of_existing(const std::string& path) {
    return identity_of(path).exists() ? DatabaseLock(path) : DatabaseLock();
  }
  void end(Transaction& transaction) {
    names.refresh_views();
    if (at_commit) at_commit->at_commit();
    require_files();
    transaction.commit();
    // A log that went in the instant of the commit: what it holds is moved before anybody is told.
    // The commit stands in the open log in any case, and what comes after it is refused.
    if (files.look() == DatabaseFiles::log_gone)
      static_cast<void>(answered([this] { move_log(SQLITE_CHECKPOINT_FULL); }));
  }
  void move_log(int mode) {
    const int code = sqlite3_wal_checkpoint_v2(db.handle(), nullptr, mode, nullptr, nullptr);
    files.wrote();
    if (code != SQLITE_OK) db.fail_now("moving the log into the database");
  }
  // Into a file that is not the record any more nothing is written, nor into a log that is on no
  // path and goes with this process: a full disk or a reader's view could keep it from the database
  // when the commit stands already.
  void require_files() {
    const DatabaseFiles state = files.look();
    if (state == DatabaseFiles::good) return;
    if (state == DatabaseFiles::log_gone && sqlite3_get_autocommit(db.handle()) != 0)
      static_cast<void>(answered([this] { move_log(SQLITE_CHECKPOINT_PASSIVE); }));
    throw StorageFailure{files_error(state, db.path())};
  }
  void require_writable() const {
    if (!read_only && at_commit == nullptr) db.refuse_closed();
    if (read_only)
      throw_failure(ErrorCode::failed_precondition, reasons::kReadOnly,
                    "database " + db.path() +
                        " was opened for reading: write through the store that the daemon opened");
  }
};

}  // namespace driftwise::storage
