#pragma once
// The record against its chain, step by step; each step has its own view of the database.
//
// Units of a kind that grows are compared as the chain names them, in step with the table, so that
// the memory does not grow with the record. Of the others the newest digest of each is kept, and
// compared at the end.

#include <map>
#include <optional>
#include <string>

#include "server/core/records/audit_records.h"
#include "storage/chain/chain_rows.h"
#include "storage/chain/protected_tables.h"
#include "storage/chain/thinned_entry.h"

namespace driftwise::storage {

class ChainCheck {
 public:
  static constexpr int kEntriesPerStep = 500;

  // outside: a head that was kept elsewhere.
  ChainCheck(Database& db, ProtectedTables& tables, std::optional<ChainHead> outside);

  // False: that was the last one.
  bool step();
  const ChainReport& report() const { return report_; }

 private:
  // Where the chain has the newest digest of a unit.
  struct Newest {
    std::int64_t entry = 0;
    std::size_t offset = 0;
    std::string digest;
  };
  void check_definitions();
  void check_entry(const ChainEntry& entry);
  void check_units(const ChainEntry& entry);
  void check_growing(const UnitKind& kind, const Unit& expected, std::int64_t entry);
  void check_thinned(const UnitKind& kind, const Unit& expected, const ThinnedEntry& thinned,
                     std::int64_t entry);
  bool step_to(const UnitKind& kind, const Unit& expected, std::int64_t entry);
  void check_rest(const UnitKind& kind);
  void check_end(const ChainEntry& newest);
  void report_inserted(const UnitKind& kind, std::string_view key);
  void compare(const Unit& expected, const Unit& found, std::int64_t entry);
  void tell(std::string sentence);

  Database& db_;
  ProtectedTables& tables_;
  std::optional<ChainHead> outside_;
  ChainReport report_;
  bool begun_ = false;
  std::int64_t last_entry_;
  std::string head_;
  std::map<int, std::int64_t> since_;     // by kind: the entry of its newest layout
  std::map<int, std::int64_t> last_key_;  // of a kind that grows
  std::map<int, std::map<std::string, Newest>> newest_;
  ThinnedStretches thinned_;
  digest::Sha256 sha_;
};

}  // namespace driftwise::storage
