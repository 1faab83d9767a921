#pragma once
// Care for the database's own files. Calls block; the object belongs to its store's thread. What
// may be asked of a read-only store is marked so.

#include <functional>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/result.h"

namespace driftwise {

// What stat says of the files behind an open database.
enum class DatabaseFiles {
  good,
  log_gone,     // the log was deleted, replaced or cut off: what it holds is on no other disk page
  moved,        // no file at the database's path
  replaced,     // another file at the database's path
  overwritten,  // the same file, written by another program
};

// One table's check of its pages.
struct TableCheck {
  std::string table;
  CellTime checked;
  std::string trouble;  // empty: clean
};
struct DatabaseChecks {
  CellTime begun;                  // of the present pass; utc_ns 0: none was ever begun
  CellTime last_clean;             // when a pass last ended with every table clean; utc_ns 0: never
  std::vector<TableCheck> tables;  // the last check of each
};

class UpkeepStore {
 public:
  virtual ~UpkeepStore() = default;
  virtual DatabaseFiles files() = 0;
  // The log is gone: everything it holds goes into the database at once. The store that writes.
  virtual Result<void> secure() = 0;
  // Closes the connection and opens the path anew, with a log of its own. When no other connection
  // is left, closing moves the log into the database. The store that writes keeps its lock.
  virtual Result<void> reopen() = 0;
  // The record that is held open, wherever its file is, into a new file. Errors: already_exists
  // (there is such a file), those of the disk.
  virtual Result<void> copy_to(const std::string& path) = 0;

  // Read-only stores too:
  virtual Result<std::vector<std::string>> tables() = 0;
  // SQLite's quick_check of one table and its indexes: the pages' structure, not the values in
  // them. Result: what is wrong, empty: nothing. give_way is asked every few milliseconds; when it
  // says true the check ends with cancelled GAVE_WAY.
  // An empty table: a first look whatever the size: header, schema, the configurations and the
  // newest points with their values and readings, each read through.
  virtual Result<std::string> check(const std::string& table,
                                    const std::function<bool()>& give_way) = 0;
  virtual Result<DatabaseChecks> checks() = 0;
  // The store that writes. begun: of the pass that the check belongs to; all_clean: it was the
  // pass' last table, and none had trouble.
  virtual Result<void> keep_check(const TableCheck& check, CellTime begun, bool all_clean) = 0;
};

}  // namespace driftwise
