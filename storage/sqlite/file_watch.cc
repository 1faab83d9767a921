#include "storage/sqlite/file_watch.h"

#include <sys/stat.h>

#include "server/core/reasons.h"

namespace driftwise::storage {
namespace {

// Of SQLite's log: docs "WAL File Format" (sqlite.org/walformat.html).
constexpr std::int64_t kLogHeaderBytes = 32, kFrameHeaderBytes = 24;
constexpr std::int64_t kNsPerS = 1'000'000'000;

}  // namespace

FileWatch::Stamp FileWatch::stamp_of(const std::string& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) return {};
  return {{found.st_dev, found.st_ino},
          found.st_size,
          found.st_mtim.tv_sec * kNsPerS + found.st_mtim.tv_nsec};
}

void FileWatch::begin(const std::string& path, std::int64_t page_bytes) {
  path_ = path;
  page_bytes_ = page_bytes;
  log_pages_ = 0;
  database_ = stamp_of(path);
  log_ = identity_of(path + "-wal");
}

void FileWatch::wrote() {
  const Stamp now = stamp_of(path_);
  // Only the same file: a checkpoint goes to the file that is held open, wherever it is by now.
  if (now.identity == database_.identity) database_ = now;
}

DatabaseFiles FileWatch::look() {
  if (!database_.identity.exists()) return DatabaseFiles::good;
  const Stamp now = stamp_of(path_);
  if (!now.identity.exists()) return DatabaseFiles::moved;
  if (now.identity != database_.identity) return DatabaseFiles::replaced;
  if (now != database_) return DatabaseFiles::overwritten;
  const Stamp log = stamp_of(path_ + "-wal");
  if (!log_.exists()) log_ = log.identity;  // SQLite makes it with the first transaction
  const std::int64_t least_bytes =
      log_pages_ == 0 ? 0 : kLogHeaderBytes + log_pages_ * (kFrameHeaderBytes + page_bytes_);
  if (log.identity != log_ || log.bytes < least_bytes) return DatabaseFiles::log_gone;
  return DatabaseFiles::good;
}

Error files_error(DatabaseFiles state, const std::string& path) {
  const char* end =
      ": nothing more is stored and the run waits; what is held open is copied beside it (the "
      "alarm names the copy): ";
  switch (state) {
    case DatabaseFiles::log_gone:
      return {ErrorCode::resource_exhausted, reasons::kDatabaseLogGone,
              "the log of database " + path + " (" + path +
                  "-wal) was deleted or cut off by another program: nothing was written. The "
                  "daemon moves what the log holds into the database and begins a new one; then "
                  "the same call succeeds. If it takes more than some seconds, the alarm says what "
                  "it waits for"};
    case DatabaseFiles::moved:
      return {ErrorCode::resource_exhausted, reasons::kDatabaseMoved,
              "database " + path + " is no longer at its path" + end +
                  "put the file back there and the cell continues, or stop the daemon and put the "
                  "copy there"};
    case DatabaseFiles::replaced:
      return {ErrorCode::resource_exhausted, reasons::kDatabaseReplaced,
              "another file has taken the place of database " + path + end +
                  "put the first file back and the cell continues, or stop the daemon, decide "
                  "which of the files is the record, and start it again"};
    default:
      return {ErrorCode::resource_exhausted, reasons::kDatabaseOverwritten,
              "another program has written into database " + path + end +
                  "stop the daemon, put the copy or a backup in its place, and start it again"};
  }
}

}  // namespace driftwise::storage
