#pragma once
// Protected tables of the record, in units. A unit is a row together with the rows that belong to
// it: a reading with its values, a point with its values. The chain holds one digest per unit and a
// short mark per row, so that a changed row has a name. docs/database.md has the list.
//
// Thread: that of the connection. Lifetime: as long as the connection is open, whose kept
// statements are keyed by texts held here.

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/digest/sha256.h"
#include "storage/sqlite/database.h"

namespace driftwise::storage {

// A kind of unit. key: columns that each of its tables has, and that say which unit a row belongs
// to. grows: units are added in ascending order of one integer key, and never changed or deleted.
struct UnitKind {
  int number;  // in the chain; never used again for another kind
  std::vector<const char*> key;
  std::vector<const char*> tables;
  bool grows = false;
};
std::span<const UnitKind> unit_kinds();
const UnitKind* unit_kind(std::int64_t number);  // nullptr: there is none

// A row within its unit: the unit's table by position, the other columns of its primary key as
// bytes, and the CRC-32 of its bytes.
struct RowMark {
  int table = 0;
  std::string key;
  std::uint32_t crc = 0;
  bool operator==(const RowMark&) const = default;
};

struct Unit {
  const UnitKind* kind = nullptr;
  std::string key;            // as bytes (value_bytes.h)
  std::string digest;         // 32 bytes: over kind, key and every row
  std::vector<RowMark> rows;  // none: it is deleted
};

// A unit as it stands in an entry of the chain: kind, key, digest, rows.
void add_unit(std::string& bytes, const Unit& unit);

class BytesReader;

class ProtectedTables {
 public:
  // Reads the tables' columns. Tables that the database lacks (an older schema) have none.
  explicit ProtectedTables(Database& db);
  ~ProtectedTables();
  ProtectedTables(const ProtectedTables&) = delete;
  ProtectedTables& operator=(const ProtectedTables&) = delete;

  // "8 reading(reading_id,device_id,...) reading_value(...)": what a digest of this kind is over.
  std::string layout(const UnitKind& kind) const;

  // A row's table, as SQLite's hook names it; nullptr: not protected.
  struct Place {
    std::string table;
    const UnitKind* kind;
    int number;                    // its place in UnitKind::tables
    std::vector<int> key_columns;  // their numbers in the table: of the unit's key,
    std::vector<int> rest;         // of the primary key besides,
    std::vector<int> stored;       // and all that are stored
  };
  const Place* place_of(std::string_view table) const;

  // What add_unit wrote; false: what stands there is no unit.
  bool read(BytesReader& reader, Unit& unit) const;
  // "reading_value with reading_id 812, channel_id 7".
  std::string name_of(const UnitKind& kind, std::string_view key, const RowMark& row) const;

  // A unit made row by row, in the order of the tables and of their primary keys. bytes: the row's
  // stored columns.
  void begin(Unit& unit, const UnitKind& kind, std::string_view key);
  void add_row(Unit& unit, int table, std::string rest_key, std::string_view bytes);
  void finish(Unit& unit);

  // The unit as the database has it now.
  Unit load(const UnitKind& kind, std::string_view key);
  // Keys of all its units, in ascending order by their bytes; each once.
  std::vector<std::string> keys(const UnitKind& kind);
  // Keys in one of its tables (by position) above this one, in the table's order, each once, at
  // most limit; after empty: from the first on.
  std::vector<std::string> keys_after(const UnitKind& kind, std::size_t table,
                                      std::string_view after, int limit);
  // Whether a table before that one has rows of the unit.
  bool is_before(const UnitKind& kind, std::size_t table, std::string_view key);
  // Of a kind that grows: the first key above this one. nullopt: there is none.
  static constexpr std::int64_t kBelowAllKeys = std::numeric_limits<std::int64_t>::min();
  std::optional<std::int64_t> next_key(const UnitKind& kind, std::int64_t after);

 private:
  struct TableOf;
  struct Statements;
  const Statements& statements(const UnitKind& kind) const;
  const TableOf* table_of(const UnitKind& kind, int number) const;

  Database& db_;
  digest::Sha256 sha_;
  std::vector<Statements> kinds_;
  std::vector<Place> places_;
  mutable const Place* last_ = nullptr;  // rows of a table come one after the other
  std::string row_;
};

}  // namespace driftwise::storage
