#pragma once
// Lock of a database file: held by the one process that may write it, from opening to closing or
// death. SQLite's own locks last for a transaction and would let a second daemon write between two
// points. Key: device and inode, so that every name of the file (symbolic link, hard link, "./x")
// meets at one lock, and no file has to be kept beside it.

#include <string>

#include "server/locks/kernel_lock.h"

namespace driftwise::storage {

// Which file a path leads to, by stat: the file itself is not opened, because closing it would drop
// SQLite's locks on it.
struct FileIdentity {
  unsigned long long device = 0, inode = 0;  // inode 0: there is none
  bool exists() const { return inode != 0; }
  bool operator==(const FileIdentity&) const = default;
};
FileIdentity identity_of(const std::string& path);

class DatabaseLock {
 public:
  DatabaseLock() = default;  // holds nothing
  // Takes the lock of the file at the path, which must exist, or throws: failed_precondition
  // DATABASE_IN_USE naming the process that has it.
  explicit DatabaseLock(const std::string& database_path);

  const FileIdentity& file() const { return file_; }

 private:
  FileIdentity file_;
  locks::KernelLock lock_;
};

}  // namespace driftwise::storage
