#include "storage/chain/protected_tables.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <set>

#include "storage/chain/value_bytes.h"

namespace driftwise::storage {
namespace {

// The columns' numbers of a table's primary key, and the names of those that are stored.
struct Columns {
  std::vector<std::string> stored;
  std::vector<std::string> primary_key;
  std::vector<int> numbers;  // of the stored ones
};

Columns columns_of(Database& db, const std::string& table) {
  Columns found;
  Query query(db,
              "SELECT name, cid, pk, hidden FROM pragma_table_xinfo(?) WHERE hidden = 0 ORDER BY "
              "cid");
  query.bind(table);
  std::vector<std::pair<std::int64_t, std::string>> key;
  while (query.row()) {
    found.stored.push_back(query.text(0));
    found.numbers.push_back(static_cast<int>(query.integer(1)));
    if (query.integer(2) > 0) key.emplace_back(query.integer(2), query.text(0));
  }
  std::ranges::sort(key);
  for (auto& [position, name] : key) found.primary_key.push_back(std::move(name));
  return found;
}

std::string joined(const std::vector<std::string>& names, const std::string& between) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : between) + name;
  return text;
}

std::uint32_t crc32_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

// Binds the values that stand in these bytes.
void bind_bytes(Database& db, sqlite3_stmt* statement, std::string_view key) {
  BytesReader reader(key);
  for (int position = 1; !reader.at_end(); ++position) {
    const std::string_view value = reader.value();
    BytesReader one(value);
    int code = SQLITE_MISMATCH;
    if (!value.empty() && value.front() <= 8) {
      code = sqlite3_bind_int64(statement, position, one.integer());
    } else if (!value.empty()) {
      one.fixed(1);
      const auto text = one.fixed(static_cast<std::size_t>(one.integer()));
      code = sqlite3_bind_text64(statement, position, text.data(), text.size(), SQLITE_TRANSIENT,
                                 SQLITE_UTF8);
    }
    if (code != SQLITE_OK) db.fail_now(sqlite3_sql(statement));
  }
}

// Resets a kept statement at the end of its use.
class Use {
 public:
  Use(Database& db, const std::string& sql) : db_(db), statement_(db.kept(sql.c_str())) {}
  ~Use() { sqlite3_reset(statement_); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;
  sqlite3_stmt* get() const { return statement_; }
  bool row() {
    errno = 0;
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) db_.fail_now(sqlite3_sql(statement_), errno);
    return code == SQLITE_ROW;
  }

 private:
  Database& db_;
  sqlite3_stmt* statement_;
};

}  // namespace

std::span<const UnitKind> unit_kinds() {
  // A number once given stays. What belongs to no kind, and why: docs/database.md.
  static const std::vector<UnitKind> kinds = {
      {1, {"hash"}, {"cell_config"}},
      {2, {"start_id"}, {"configuration_start"}},
      {3, {"run_id"}, {"run"}},
      {4, {"run_id"}, {"run_progress"}},
      {5, {"run_id"}, {"run_configuration"}},
      {6, {"run_id"}, {"imported_file", "imported_metadata", "imported_column"}},
      {7, {"channel_id"}, {"channel"}},
      {8, {"device_id"}, {"device"}},
      {9, {"datum_id"}, {"datum", "datum_value"}},
      {10, {"point_id"}, {"point", "point_value"}, true},
      {11, {"attempt_id"}, {"attempt"}, true},
      {12, {"reading_id"}, {"reading", "reading_value"}, true},
      {13, {"device_id", "start_ns", "sequence"}, {"rejected_value"}},
      {14, {"at_ns", "ordinal"}, {"move"}},
      {15, {"model_id"}, {"model", "model_correction"}},
      {16, {"promotion_id"}, {"promotion"}},
      {17, {"event_id"}, {"event"}, true},
      {18, {"exclusion_id"}, {"exclusion", "exclusion_row", "suspect_mark"}},
      {19, {"note_id"}, {"note"}},
      {20, {"diagnosis_id"}, {"diagnosis", "diagnosis_run"}},
      {21, {"correction_id"}, {"correction", "correction_change"}},
      {22, {"extension_id"}, {"extension", "extension_exclusion"}},
      {23, {"improvement_id"}, {"improvement"}},
      {24, {"improvement_id", "number"}, {"improvement_turn", "improvement_gain"}},
      {25, {"alarm_id"}, {"alarm"}},
      {26, {"trajectory_id"}, {"trajectory"}},
      {27, {"stop_id"}, {"stop"}},
      {28, {"clock_id"}, {"clock"}},
      {29, {"one"}, {"database_identity"}},
      {30, {"audit_id"}, {"audit"}, true},
      {31, {"thinning_id"}, {"thinning", "thinned_value"}},
      {32, {"entry_id"}, {"queue_entry", "queue_result"}},
      {33, {"one"}, {"queue_hold"}},
      {34, {"run_id"}, {"run_metadata", "queue_run"}},
      {35, {"plan_id"}, {"plan", "plan_model"}},
      {36, {"plan_promotion_id"}, {"plan_promotion"}},
      {37, {"time_note_id"}, {"time_note"}},
      {38, {"closure_id"}, {"closure", "closure_coordinate"}},
      {39, {"point_id"}, {"repeated_point"}},
      {40, {"rest_id"}, {"rest"}},
      {41, {"indentation_id"}, {"indentation"}},
      {42, {"point_id"}, {"passage"}},
  };
  return kinds;
}

const UnitKind* unit_kind(std::int64_t number) {
  const auto kinds = unit_kinds();
  const auto found = std::ranges::find(kinds, number, &UnitKind::number);
  return found == kinds.end() ? nullptr : &*found;
}

void add_unit(std::string& bytes, const Unit& unit) {
  add_integer(bytes, unit.kind->number);
  bytes += unit.key;
  bytes += unit.digest;
  add_integer(bytes, static_cast<std::int64_t>(unit.rows.size()));
  for (const RowMark& row : unit.rows) {
    add_integer(bytes, row.table);
    bytes += row.key;
    for (int shift = 24; shift >= 0; shift -= 8)
      bytes += static_cast<char>(static_cast<unsigned char>(row.crc >> shift));
  }
}

// One table of a kind: its rows of one unit in the order of the primary key. rest: the columns of
// the primary key that are not of the unit's key; they stand before the stored ones in a row.
struct ProtectedTables::TableOf {
  int number;  // its place in UnitKind::tables
  std::string name;
  std::vector<std::string> stored, rest;
  int stored_from() const { return static_cast<int>(rest.size()); }
  std::string rows_sql, keys_sql, first_keys_sql, keys_after_sql, next_sql;
};

struct ProtectedTables::Statements {
  const UnitKind* kind;
  std::vector<TableOf> tables;
};

ProtectedTables::ProtectedTables(Database& db) : db_(db) {
  for (const UnitKind& kind : unit_kinds()) {
    Statements of{&kind, {}};
    std::string where, key_list, marks;
    for (const char* column : kind.key) {
      where += (where.empty() ? "" : " AND ") + std::string(column) + " = ?";
      key_list += (key_list.empty() ? "" : ", ") + std::string(column);
      marks += marks.empty() ? "?" : ", ?";
    }
    for (std::size_t i = 0; i < kind.tables.size(); ++i) {
      const std::string name = kind.tables[i];
      Columns columns = columns_of(db, name);
      if (columns.stored.empty()) continue;
      Place place{name, &kind, static_cast<int>(i), {}, {}, columns.numbers};
      const auto number_of = [&columns](std::string_view column, std::vector<int>& numbers) {
        const auto at = std::ranges::find(columns.stored, column);
        if (at == columns.stored.end()) return;  // a damaged schema: the layout tells
        numbers.push_back(columns.numbers[static_cast<std::size_t>(at - columns.stored.begin())]);
      };
      for (const char* column : kind.key) number_of(column, place.key_columns);
      std::vector<std::string> rest;
      for (const auto& column : columns.primary_key)
        if (std::ranges::find(kind.key, column) == kind.key.end()) rest.push_back(column);
      for (const auto& column : rest) number_of(column, place.rest);
      const std::string order = rest.empty() ? "" : " ORDER BY " + joined(rest, ", ");
      TableOf table{static_cast<int>(i), name, columns.stored, rest, "", "", "", "", ""};
      table.rows_sql = "SELECT " + joined(rest, ", ") + (rest.empty() ? "" : ", ") +
                       joined(columns.stored, ", ") + " FROM main." + name + " WHERE " + where +
                       order;
      table.keys_sql = "SELECT DISTINCT " + key_list + " FROM main." + name;
      const std::string some = " ORDER BY " + key_list + " LIMIT ";
      table.first_keys_sql = table.keys_sql + some + "?";
      table.keys_after_sql =
          table.keys_sql + " WHERE (" + key_list + ") > (" + marks + ")" + some + "?";
      table.next_sql = "SELECT " + key_list + " FROM main." + name + " WHERE " + key_list +
                       " > ? ORDER BY " + key_list + " LIMIT 1";
      of.tables.push_back(std::move(table));
      places_.push_back(std::move(place));
    }
    kinds_.push_back(std::move(of));
  }
  std::ranges::sort(places_, {}, &Place::table);
}

ProtectedTables::~ProtectedTables() = default;

const ProtectedTables::Statements& ProtectedTables::statements(const UnitKind& kind) const {
  return kinds_[static_cast<std::size_t>(&kind - unit_kinds().data())];
}

std::string ProtectedTables::layout(const UnitKind& kind) const {
  std::string text = std::to_string(kind.number);
  for (const TableOf& table : statements(kind).tables)
    text += " " + table.name + "(" + joined(table.stored, ",") + ")";
  return text;
}

const ProtectedTables::Place* ProtectedTables::place_of(std::string_view table) const {
  if (last_ != nullptr && last_->table == table) return last_;
  const auto found = std::ranges::lower_bound(
      places_, table, {}, [](const Place& one) { return std::string_view(one.table); });
  if (found == places_.end() || found->table != table) return nullptr;
  return last_ = &*found;
}

const ProtectedTables::TableOf* ProtectedTables::table_of(const UnitKind& kind, int number) const {
  const auto& tables = statements(kind).tables;
  const auto found = std::ranges::find(tables, number, &TableOf::number);
  return found == tables.end() ? nullptr : &*found;
}

bool ProtectedTables::read(BytesReader& reader, Unit& unit) const {
  unit = {unit_kind(reader.integer()), {}, {}, {}};
  if (!reader.good() || unit.kind == nullptr) return false;
  for (std::size_t i = 0; i < unit.kind->key.size(); ++i) unit.key += reader.value();
  unit.digest = reader.fixed(digest::kSha256Bytes);
  const std::int64_t rows = reader.integer();
  for (std::int64_t i = 0; i < rows && reader.good(); ++i) {
    RowMark mark;
    mark.table = static_cast<int>(reader.integer());
    const TableOf* table = table_of(*unit.kind, mark.table);
    if (table == nullptr) return false;
    for (std::size_t left = table->rest.size(); left > 0; --left) mark.key += reader.value();
    for (const char c : reader.fixed(4)) mark.crc = (mark.crc << 8) | static_cast<unsigned char>(c);
    unit.rows.push_back(std::move(mark));
  }
  return reader.good();
}

std::string ProtectedTables::name_of(const UnitKind& kind, std::string_view key,
                                     const RowMark& row) const {
  const TableOf* table = table_of(kind, row.table);
  std::string text = kind.tables[static_cast<std::size_t>(row.table)];
  BytesReader unit_key(key), row_key(row.key);
  const char* before = " with ";
  for (const char* column : kind.key) {
    text += before + std::string(column) + " " + value_text(unit_key.value());
    before = ", ";
  }
  if (table == nullptr) return text;
  for (const auto& column : table->rest) text += ", " + column + " " + value_text(row_key.value());
  return text;
}

void ProtectedTables::begin(Unit& unit, const UnitKind& kind, std::string_view key) {
  unit = {&kind, std::string(key), {}, {}};
  row_.clear();
  add_integer(row_, kind.number);
  sha_.begin().add(row_).add(key);
}

void ProtectedTables::add_row(Unit& unit, int table, std::string rest_key, std::string_view bytes) {
  row_.clear();
  add_integer(row_, table);
  row_ += bytes;
  sha_.add(row_);
  unit.rows.push_back({table, std::move(rest_key), crc32_of(row_)});
}

void ProtectedTables::finish(Unit& unit) { unit.digest = sha_.finish(); }

Unit ProtectedTables::load(const UnitKind& kind, std::string_view key) {
  Unit unit;
  begin(unit, kind, key);
  std::string row;
  for (const TableOf& table : statements(kind).tables) {
    Use use(db_, table.rows_sql);
    bind_bytes(db_, use.get(), key);
    while (use.row()) {
      std::string rest_key;
      for (int column = 0; column < table.stored_from(); ++column)
        add_column(rest_key, use.get(), column);
      row.clear();
      const int columns = table.stored_from() + static_cast<int>(table.stored.size());
      for (int column = table.stored_from(); column < columns; ++column)
        add_column(row, use.get(), column);
      add_row(unit, table.number, std::move(rest_key), row);
    }
  }
  finish(unit);
  return unit;
}

std::vector<std::string> ProtectedTables::keys(const UnitKind& kind) {
  std::set<std::string> found;
  for (const TableOf& table : statements(kind).tables) {
    Use use(db_, table.keys_sql);
    while (use.row()) {
      std::string key;
      for (int column = 0; column < sqlite3_column_count(use.get()); ++column)
        add_column(key, use.get(), column);
      found.insert(std::move(key));
    }
  }
  return {found.begin(), found.end()};
}

std::vector<std::string> ProtectedTables::keys_after(const UnitKind& kind, std::size_t table,
                                                     std::string_view after, int limit) {
  std::vector<std::string> found;
  const TableOf* of = table_of(kind, static_cast<int>(table));
  if (of == nullptr) return found;
  const std::string& sql = after.empty() ? of->first_keys_sql : of->keys_after_sql;
  Use use(db_, sql);
  bind_bytes(db_, use.get(), after);
  if (sqlite3_bind_int(use.get(), sqlite3_bind_parameter_count(use.get()), limit) != SQLITE_OK)
    db_.fail_now(sql);
  while (use.row()) {
    std::string key;
    for (int column = 0; column < sqlite3_column_count(use.get()); ++column)
      add_column(key, use.get(), column);
    found.push_back(std::move(key));
  }
  return found;
}

bool ProtectedTables::is_before(const UnitKind& kind, std::size_t table, std::string_view key) {
  for (const TableOf& of : statements(kind).tables) {
    if (of.number >= static_cast<int>(table)) break;
    Use use(db_, of.rows_sql);
    bind_bytes(db_, use.get(), key);
    if (use.row()) return true;
  }
  return false;
}

std::optional<std::int64_t> ProtectedTables::next_key(const UnitKind& kind, std::int64_t after) {
  std::optional<std::int64_t> next;
  for (const TableOf& table : statements(kind).tables) {
    Use use(db_, table.next_sql);
    if (sqlite3_bind_int64(use.get(), 1, after) != SQLITE_OK) db_.fail_now(table.next_sql);
    if (!use.row()) continue;
    const std::int64_t found = sqlite3_column_int64(use.get(), 0);
    next = next ? std::min(*next, found) : found;
  }
  return next;
}

}  // namespace driftwise::storage
