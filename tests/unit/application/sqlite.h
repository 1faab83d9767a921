#pragma once
// The real store under the cell in memory.

#include "server/application/cell/cell.h"
#include "storage/sqlite_store.h"

namespace driftwise::tests {

inline const OpenStore kSqlite = [](const std::string& path, bool read_only) {
  return storage::open_sqlite_store(path, read_only);
};

}  // namespace driftwise::tests
