#include "storage/sqlite/failure.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>

#include "server/core/reasons.h"

namespace driftwise::storage {

void throw_failure(ErrorCode code, std::string reason, std::string message) {
  throw StorageFailure{{code, std::move(reason), std::move(message)}};
}

Error error_from_sqlite(int code, int system_errno, const std::string& file,
                        const std::string& doing, const std::string& detail) {
  std::string what =
      "database " + file + ": " + doing + ": " + detail + " (SQLite " + std::to_string(code);
  if (system_errno != 0) what += std::string(", ") + std::strerror(system_errno);
  what += "): ";

  // SQLite reports a full disk as SQLITE_FULL from a write, but as an I/O error from the
  // shared-memory file.
  const bool no_space =
      code == SQLITE_FULL || code == SQLITE_IOERR_SHMSIZE ||
      ((code & 0xff) == SQLITE_IOERR && (system_errno == ENOSPC || system_errno == EDQUOT));
  if (no_space)
    return {
        ErrorCode::resource_exhausted, reasons::kDiskFull,
        what +
            "the disk is full; nothing was written: free some space, then the same call succeeds"};
  // Linux takes writing from a file system that has an error of its own. Files that are open stay
  // so. ext4 then takes no remount: it has to be unmounted and checked, which the daemon's open
  // files prevent.
  if (system_errno == EROFS && ((code & 0xff) == SQLITE_IOERR || (code & 0xff) == SQLITE_READONLY))
    return {
        ErrorCode::resource_exhausted, reasons::kReadOnly,
        what +
            "the disk can only be read now (dmesg says why); nothing was written: mount it for "
            "writing, then the same call succeeds. After an error of its own ext4 cannot be "
            "mounted anew under open files: end the daemon, unmount, check (fsck), mount, start "
            "the daemon"};
  switch (code) {
    case SQLITE_CONSTRAINT_UNIQUE:
    case SQLITE_CONSTRAINT_PRIMARYKEY:
    case SQLITE_CONSTRAINT_ROWID:
    case SQLITE_CONSTRAINT_TRIGGER:  // point_once
      return {ErrorCode::already_exists, reasons::kAlreadyStored,
              what + "it is stored already; nothing was written"};
    case SQLITE_CONSTRAINT_FOREIGNKEY:
      return {
          ErrorCode::not_found, reasons::kNoSuchRecord,
          what + "it names a run, datum or model that is not in the database; nothing was written"};
    default:
      break;
  }
  switch (code & 0xff) {
    case SQLITE_IOERR:
      return {ErrorCode::data_loss, reasons::kDiskError,
              what +
                  "the disk failed and the change was not acknowledged: look at the disk (dmesg), "
                  "then try again"};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {ErrorCode::data_loss, reasons::kDatabaseDamaged,
              what +
                  "the file is damaged or no database: keep a copy, then restore a backup, or save "
                  "what can be "
                  "read with: sqlite3 " +
                  file + " .recover"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::failed_precondition, reasons::kDatabaseLocked,
              what +
                  "another program holds the database: end its transaction (a sqlite3 shell?), "
                  "then try again"};
    case SQLITE_READONLY:
      return {ErrorCode::failed_precondition, reasons::kReadOnly,
              what +
                  "the file cannot be written: open it for writing and look at the rights of file "
                  "and folder"};
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {ErrorCode::not_found, reasons::kCannotOpen,
              what + "look at the path and at the rights of file and folder"};
    case SQLITE_NOMEM:
      return {ErrorCode::resource_exhausted, reasons::kOutOfMemory,
              what + "out of memory; nothing was written"};
    case SQLITE_TOOBIG:
      return {ErrorCode::invalid_argument, reasons::kTooBig,
              what + "a text is longer than the database takes"};
    default:
      return {ErrorCode::internal, reasons::kSqliteError, what + "please report this as a bug"};
  }
}

}  // namespace driftwise::storage
