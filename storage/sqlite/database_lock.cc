#include "storage/sqlite/database_lock.h"

#include <sys/stat.h>

#include <cstdio>

#include "server/core/reasons.h"
#include "storage/sqlite/failure.h"

namespace driftwise::storage {

FileIdentity identity_of(const std::string& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) return {};
  return {found.st_dev, found.st_ino};
}

DatabaseLock::DatabaseLock(const std::string& database_path) : file_(identity_of(database_path)) {
  char name[64];
  std::snprintf(name, sizeof name, "database/%llx-%llx", file_.device, file_.inode);
  auto lock = locks::KernelLock::take(name);
  if (!lock) {
    if (lock.error().reason != reasons::kLockHeld) throw StorageFailure{lock.error()};
    throw_failure(ErrorCode::failed_precondition, reasons::kDatabaseInUse,
                  "database " + database_path + " is being written by " + lock.error().message +
                      ": stop that daemon, or give this cell a database of its own");
  }
  lock_ = std::move(*lock);
}

}  // namespace driftwise::storage
