#pragma once
// "<database>.lock": held by the one process that may write a database, from opening to closing or
// death. SQLite's own locks last for a transaction and would let a second daemon write between two
// points.

#include <string>

namespace driftwise::storage {

class LockFile {
 public:
  LockFile() = default;
  // Takes the lock or throws: failed_precondition DATABASE_IN_USE naming the process that has it.
  explicit LockFile(const std::string& database_path);
  ~LockFile();
  LockFile(LockFile&& other) noexcept;
  LockFile& operator=(LockFile&& other) noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace driftwise::storage
