#pragma once
// Rows of the table chain: entries 1, 2, 3, ... without a gap, each with the head of the chain at
// it: SHA-256 of the head before it, its number, what it is, and its bytes (docs/database.md).

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/digest/sha256.h"
#include "storage/sqlite/database.h"

namespace driftwise::storage {

namespace chain_entry {
// Units that a transaction changed; units that were there when the chain began, or when their
// tables got other columns; and which columns those are.
inline constexpr const char* kRows = "rows";
inline constexpr const char* kBegin = "begin";
inline constexpr const char* kLayout = "layout";
// Readings that a transaction removed by thinning.
inline constexpr const char* kThinned = "thinned";
}  // namespace chain_entry

struct ChainEntry {
  std::int64_t number = 0;
  std::string what;
  std::string bytes;
  std::string head;  // 32 bytes, as stored
};

// The head at an entry. before: the head of the one before it; of the first entry, 32 zero bytes.
// sha: kept by the caller, for making one costs more than an entry.
std::string chain_head(digest::Sha256& sha, const std::string& before, std::int64_t number,
                       const std::string& what, const std::string& bytes);
extern const std::string kChainRoot;  // 32 zero bytes

// Inside a write transaction. Throws StorageFailure.
void append_entry(Database& db, digest::Sha256& sha, const std::string& what,
                  const std::string& bytes);

// The newest entry, without its bytes; number 0: the chain has not begun.
ChainEntry newest_entry(Database& db);
std::optional<ChainEntry> read_entry(Database& db, std::int64_t number);
// The newest layout that the chain has of a kind of units, and the number of its entry; empty, 0.
struct ChainLayout {
  std::string text;
  std::int64_t entry = 0;
};
ChainLayout newest_layout(Database& db, int kind);

}  // namespace driftwise::storage
