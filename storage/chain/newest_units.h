#pragma once
// Newest digest that the chain has of each unit whose kind does not only grow. It stands in a
// temporary file of SQLite, which has no name and goes with the object: what a check needs in
// memory does not grow with the record.
//
// Thread: one. Throws StorageFailure: those of the disk.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "storage/sqlite/database.h"

namespace driftwise::storage {

// Where the chain names a unit.
struct NamedUnit {
  int kind = 0;
  std::string key;
  std::int64_t entry = 0;
  std::size_t offset = 0;  // in the entry's bytes
  std::string digest;
};

class NewestUnits {
 public:
  NewestUnits();
  // In the place of what is known of the unit.
  void put(const NamedUnit& unit);
  bool holds(int kind, std::string_view key);
  // The first ones above this kind and key, in the order of both; at most limit.
  std::vector<NamedUnit> after(int kind, std::string_view key, int limit);

 private:
  Database db_;
};

}  // namespace driftwise::storage
