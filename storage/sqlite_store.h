#pragma once
// The store behind server/core/ports/store.h, in one SQLite file. What a person reads in it:
// docs/database.md.
//
// Thread: each store belongs to one. Any number of read-only stores may work while one writes.
// Crash: WAL with synchronous FULL. What a call acknowledged survives the process and the power;
// what was under way is there whole or not at all.

#include <memory>
#include <string>

#include "server/core/ports/store.h"

namespace driftwise::storage {

struct SqliteOptions {
  std::string vfs;  // a registered SQLite VFS; empty: the system's
  // Store::idle() moves the log into the database from this many pages (4 KiB) on;
  // storage/sqlite_store.cc says why. A commit does it itself only beyond sixteen times as many,
  // when nobody ever calls idle().
  int checkpoint_pages = 1000;
  // idle() moves whatever is in the log at least this often, so that a lost log costs little.
  double checkpoint_every_s = 60;
  // How long a call waits while another program, a person's sqlite3 shell, holds the write lock.
  int busy_timeout_ms = 2000;
};

// Opens, creates where it is missing (writing only), migrates. path: a file, or ":memory:" for
// tests. Errors, besides those of the port: failed_precondition DATABASE_IN_USE (another process
// writes it), NOT_DRIFTWISE, SCHEMA_NEWER, SCHEMA_OLDER (read-only); not_found CANNOT_OPEN;
// data_loss DATABASE_DAMAGED.
Result<std::unique_ptr<Store>> open_sqlite_store(const std::string& path, bool read_only);
Result<std::unique_ptr<Store>> open_sqlite_store(const std::string& path, bool read_only,
                                                 const SqliteOptions& options);

}  // namespace driftwise::storage
