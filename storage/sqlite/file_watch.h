#pragma once
// Watch over the files of an open database, by stat alone: closing a descriptor of the file would
// drop SQLite's locks on it. Thread: the store's.

#include <cstdint>
#include <string>

#include "server/core/ports/upkeep_store.h"
#include "storage/sqlite/database_lock.h"

namespace driftwise::storage {

class FileWatch {
 public:
  // Watches from now on what is at the path; nothing where there is no file (":memory:").
  void begin(const std::string& path, std::int64_t page_bytes);
  // This connection wrote the database file (a checkpoint): how it is now is how it should be.
  void wrote();
  // A commit has left so many pages in the log.
  void logged(int pages) { log_pages_ = pages; }

  DatabaseFiles look();

 private:
  struct Stamp {
    FileIdentity identity;
    std::int64_t bytes = 0, modified_ns = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stamp_of(const std::string& path);

  std::string path_;
  std::int64_t page_bytes_ = 4096;
  int log_pages_ = 0;
  Stamp database_;
  FileIdentity log_;
};

// What a caller is told whose call is not executed because of the files. state: any but good.
// Error: resource_exhausted (nothing was written, the call may be repeated), DATABASE_LOG_GONE,
// DATABASE_MOVED, DATABASE_REPLACED, DATABASE_OVERWRITTEN, naming the path and what to do.
Error files_error(DatabaseFiles state, const std::string& path);

}  // namespace driftwise::storage
