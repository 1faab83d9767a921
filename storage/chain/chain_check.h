#pragma once
// The record against its chain, step by step; each step has its own view of the database.
//
// Units of a kind that grows are compared as the chain names them, in step with the table. Of the
// others the newest digest of each is kept in a temporary file, and compared when the chain is
// read, a few thousand per step. The memory does not grow with the record.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/core/records/audit_records.h"
#include "storage/chain/chain_rows.h"
#include "storage/chain/newest_units.h"
#include "storage/chain/protected_tables.h"
#include "storage/chain/thinned_entry.h"

namespace driftwise::storage {

class ChainCheck {
 public:
  static constexpr int kEntriesPerStep = 500;
  static constexpr int kUnitsPerStep = 2000;

  // outside: a head that was kept elsewhere.
  ChainCheck(Database& db, ProtectedTables& tables, std::optional<ChainHead> outside);

  // False: that was the last one.
  bool step();
  const ChainReport& report() const { return report_; }

 private:
  // How far the units that do not only grow are compared.
  struct Place {
    int kind = 0;
    std::string key;
    auto operator<=>(const Place&) const = default;
  };
  // How far the tables are searched for rows that no entry names.
  struct Search {
    std::size_t kind = 0, table = 0;  // by position
    std::string key;
  };
  void check_definitions();
  void check_entry(const ChainEntry& entry);
  void check_units(const ChainEntry& entry);
  void name(const NamedUnit& unit);
  void check_growing(const UnitKind& kind, const Unit& expected, std::int64_t entry);
  void check_thinned(const UnitKind& kind, const Unit& expected, const ThinnedEntry& thinned,
                     std::int64_t entry);
  bool step_to(const UnitKind& kind, const Unit& expected, std::int64_t entry);
  bool compare_more();
  void compare_newest(const NamedUnit& newest);
  void search_more(int& left);
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
  NewestUnits newest_;
  std::optional<Place> compared_;  // none: the chain is not read yet
  bool all_compared_ = false;
  std::vector<NamedUnit> again_;  // named anew after they were compared
  Search search_;
  ThinnedStretches thinned_;
  digest::Sha256 sha_;
};

}  // namespace driftwise::storage
