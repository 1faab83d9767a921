#pragma once
// Entry "thinned" of the chain: readings that a thinning removed, and the digest that stands for
// them. As bytes: thinning_id, kind (12), number of readings, first reading_id as INTEGERs, the
// hash (32 bytes), and a BLOB of one bit per reading_id from the first on, the lowest bit of a byte
// first; 1: removed. docs/database.md, "Thinning".

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/core/records/audit_records.h"
#include "server/digest/sha256.h"
#include "storage/chain/chain_rows.h"

namespace driftwise::storage {

inline constexpr int kReadingKind = 12;

struct ThinnedEntry {
  std::int64_t thinning = 0, count = 0, first = 0;
  std::string hash;  // SHA-256 of the digests of the readings, in the order of their ids
  std::string bits;

  std::int64_t last() const { return first + 8 * static_cast<std::int64_t>(bits.size()) - 1; }
  bool holds(std::int64_t reading) const;
};

// readings: ascending, at least one.
std::string thinned_bytes(std::int64_t thinning, std::span<const std::int64_t> readings,
                          std::string_view hash);
std::optional<ThinnedEntry> thinned_from(std::string_view bytes);

// What a check of the chain knows of thinned stretches. The readings' units stand in earlier
// entries than the one that says that they were removed, so the latter are read first.
class ThinnedStretches {
 public:
  // Entries that were added since the last call. Those of the first call have their hash compared;
  // a stretch that is thinned while the check is under way only excuses what is gone.
  void read(Database& db);
  // The stretch that the reading belongs to, its digest taken into account; nullptr: it was not
  // thinned.
  const ThinnedEntry* take(std::int64_t reading, std::string_view digest);
  // After the last unit, of the entries from `since` on: sentences on stretches whose readings were
  // others than their entry says.
  std::vector<std::string> differences(std::int64_t since);
  void tell(Database& db, ChainReport& report) const;

 private:
  struct Stretch {
    ThinnedEntry entry;
    bool compared = false;
    std::int64_t seen = 0;
    digest::Sha256 sha;
  };
  std::map<std::int64_t, Stretch> stretches_;          // by the entry of the chain
  std::multimap<std::int64_t, std::int64_t> by_last_;  // the last reading -> that entry
  std::int64_t read_up_to_ = 0, longest_ = 0;
  bool first_ = true;
};

}  // namespace driftwise::storage
