#include "storage/chain/chain_check.h"

#include <algorithm>
#include <limits>

#include "server/digest/sha256.h"
#include "storage/chain/value_bytes.h"
#include "storage/schema/schema.h"

namespace driftwise::storage {
namespace {

constexpr std::size_t kMostTold = 20;

// SQL without comments and with single spaces: what a definition means.
std::string plain_sql(const std::string& sql) {
  std::string plain;
  bool comment = false;
  for (std::size_t i = 0; i < sql.size(); ++i) {
    if (sql.compare(i, 2, "--") == 0) comment = true;
    if (sql[i] == '\n') comment = false;
    if (comment) continue;
    const bool space = sql[i] == ' ' || sql[i] == '\n';
    if (space && (plain.empty() || plain.back() == ' ')) continue;
    plain += space ? ' ' : sql[i];
  }
  return plain;
}

// Tables, indexes, triggers and views by name. The wide views follow the channels.
std::map<std::string, std::string> definitions_of(Database& db) {
  std::map<std::string, std::string> found;
  Query query(db,
              "SELECT type || ' ' || name, sql FROM sqlite_schema WHERE sql IS NOT NULL AND name "
              "NOT IN ('point_wide', 'reading_wide') AND name NOT LIKE 'sqlite_%'");
  while (query.row()) found[query.text(0)] = plain_sql(query.text(1));
  return found;
}

std::string entry_text(std::int64_t entry) {
  return "entry " + std::to_string(entry) + " of the chain";
}

}  // namespace

ChainCheck::ChainCheck(Database& db, ProtectedTables& tables, std::optional<ChainHead> outside)
    : db_(db),
      tables_(tables),
      outside_(std::move(outside)),
      last_entry_(std::numeric_limits<std::int64_t>::min()),
      head_(kChainRoot) {}

void ChainCheck::tell(std::string sentence) {
  ++report_.differences;
  if (report_.first.size() < kMostTold) report_.first.push_back(std::move(sentence));
}

// A changed definition could show other values than are stored, or change those that come.
void ChainCheck::check_definitions() {
  Database fresh(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
  migrate(fresh);
  const auto expected = definitions_of(fresh), found = definitions_of(db_);
  for (const auto& [name, sql] : expected) {
    const auto at = found.find(name);
    if (at == found.end())
      tell("the database lacks its " + name);
    else if (at->second != sql)
      tell("the definition of " + name + " differs from that of this program");
  }
  for (const auto& [name, sql] : found)
    if (!expected.contains(name)) tell("the database has a " + name + " that no Driftwise made");
  for (const UnitKind& kind : unit_kinds()) {
    const auto layout = newest_layout(db_, kind.number);
    since_[kind.number] = layout.entry;
    last_key_[kind.number] = ProtectedTables::kBelowAllKeys;
    if (layout.text != tables_.layout(kind))
      tell("the chain has other columns for table " + std::string(kind.tables.front()) +
           " than the database: '" + layout.text + "'");
  }
}

bool ChainCheck::step() {
  Transaction view(db_, Transaction::Kind::read);
  if (!begun_) check_definitions();
  begun_ = true;
  thinned_.read(db_);
  const ChainEntry newest = newest_entry(db_);
  if (newest.number == 0) tell("the chain has no entry");
  int count = 0;
  {
    Query query(db_,
                "SELECT entry_id, what, bytes, head FROM chain WHERE entry_id > ? ORDER BY "
                "entry_id LIMIT ?");
    query.bind(last_entry_, kEntriesPerStep);
    for (; query.row(); ++count)
      check_entry({query.integer(0), query.text(1), query.bytes(2), query.bytes(3)});
  }
  if (last_entry_ < newest.number && count > 0) return true;
  if (compare_more()) return true;
  check_end(newest);
  return false;
}

void ChainCheck::check_entry(const ChainEntry& entry) {
  const std::int64_t expected = std::max<std::int64_t>(last_entry_, 0) + 1;
  if (entry.number < expected)
    tell(entry_text(entry.number) + " is inserted: the first one is 1");
  else if (entry.number > expected)
    tell(entry_text(expected) + " is missing");
  else if (chain_head(sha_, head_, entry.number, entry.what, entry.bytes) != entry.head)
    tell(entry_text(entry.number) + " differs: its head does not follow from the one before it");
  last_entry_ = entry.number;
  head_ = entry.head;
  if (outside_ && outside_->entry == entry.number && outside_->hash != digest::hex_from(head_))
    tell("the chain at entry " + std::to_string(entry.number) + " has the head " +
         digest::hex_from(head_) + ", the one that was kept is " + outside_->hash +
         ": the record up to there was written anew");
  if (entry.what == chain_entry::kRows || entry.what == chain_entry::kBegin)
    check_units(entry);
  else if (entry.what == chain_entry::kThinned && !thinned_from(entry.bytes))
    tell(entry_text(entry.number) + " cannot be read");
  else if (entry.what != chain_entry::kLayout && entry.what != chain_entry::kThinned)
    tell(entry_text(entry.number) + " is of a kind that this program does not know: '" +
         entry.what + "'");
}

void ChainCheck::check_units(const ChainEntry& entry) {
  BytesReader reader(entry.bytes);
  Unit unit;
  while (!reader.at_end()) {
    const std::size_t offset = reader.at();
    if (!tables_.read(reader, unit)) {
      tell(entry_text(entry.number) + " cannot be read from byte " + std::to_string(offset) +
           " on");
      return;
    }
    // What was chained before the tables got other columns was chained again then.
    if (entry.number < since_[unit.kind->number]) continue;
    const ThinnedEntry* thinned = unit.kind->number == kReadingKind
                                      ? thinned_.take(BytesReader(unit.key).integer(), unit.digest)
                                      : nullptr;
    if (thinned != nullptr)
      check_thinned(*unit.kind, unit, *thinned, entry.number);
    else if (unit.kind->grows)
      check_growing(*unit.kind, unit, entry.number);
    else
      name({unit.kind->number, unit.key, entry.number, offset, unit.digest});
  }
}

void ChainCheck::name(const NamedUnit& unit) {
  newest_.put(unit);
  if (compared_ && (all_compared_ || Place{unit.kind, unit.key} <= *compared_))
    again_.push_back(unit);
}

// Rows before the unit that no entry names; false: the unit is out of its order.
bool ChainCheck::step_to(const UnitKind& kind, const Unit& expected, std::int64_t entry) {
  std::int64_t& last = last_key_[kind.number];
  const std::int64_t key = BytesReader(expected.key).integer();
  if (key <= last) {
    tell(entry_text(entry) + " names a row of table " + std::string(kind.tables.front()) +
         " out of its order");
    return false;
  }
  for (auto next = tables_.next_key(kind, last); next && *next < key;
       next = tables_.next_key(kind, *next)) {
    std::string inserted;
    add_integer(inserted, *next);
    report_inserted(kind, inserted);
  }
  last = key;
  return true;
}

void ChainCheck::check_growing(const UnitKind& kind, const Unit& expected, std::int64_t entry) {
  if (step_to(kind, expected, entry)) compare(expected, tables_.load(kind, expected.key), entry);
}

void ChainCheck::check_thinned(const UnitKind& kind, const Unit& expected,
                               const ThinnedEntry& thinned, std::int64_t entry) {
  if (!step_to(kind, expected, entry)) return;
  for (const RowMark& row : tables_.load(kind, expected.key).rows)
    tell(tables_.name_of(kind, expected.key, row) + " was removed by thinning " +
         std::to_string(thinned.thinning) + " and is there again");
}

void ChainCheck::report_inserted(const UnitKind& kind, std::string_view key) {
  const Unit unit = tables_.load(kind, key);
  for (const RowMark& row : unit.rows)
    tell(tables_.name_of(kind, key, row) + " is inserted: the chain has no such row");
}

void ChainCheck::compare(const Unit& expected, const Unit& found, std::int64_t entry) {
  ++report_.units;
  report_.rows += static_cast<std::int64_t>(expected.rows.size());
  if (expected.digest == found.digest) return;
  const auto name = [&](const RowMark& row) {
    return tables_.name_of(*expected.kind, expected.key, row);
  };
  const std::string since = " since " + entry_text(entry);
  using Key = std::pair<int, std::string>;
  std::map<Key, std::uint32_t> there, wanted;
  for (const RowMark& row : found.rows) there[{row.table, row.key}] = row.crc;
  for (const RowMark& row : expected.rows) wanted[{row.table, row.key}] = row.crc;
  const std::int64_t before = report_.differences;
  for (const RowMark& row : expected.rows) {
    const auto at = there.find({row.table, row.key});
    if (at == there.end())
      tell(name(row) + " is missing" + since);
    else if (at->second != row.crc)
      tell(name(row) + " differs" + since);
  }
  for (const RowMark& row : found.rows)
    if (!wanted.contains({row.table, row.key})) tell(name(row) + " is inserted" + since);
  if (report_.differences == before)
    tell((expected.rows.empty() ? "a row of table " + std::string(expected.kind->tables.front())
                                : name(expected.rows.front()) + ", or a row that belongs to it,") +
         " differs" + since);
}

void ChainCheck::compare_newest(const NamedUnit& newest) {
  const UnitKind& kind = *unit_kind(newest.kind);
  const Unit found = tables_.load(kind, newest.key);
  if (found.digest == newest.digest) {
    ++report_.units;
    report_.rows += static_cast<std::int64_t>(found.rows.size());
    return;
  }
  Unit unit{&kind, newest.key, newest.digest, {}};
  if (const auto entry = read_entry(db_, newest.entry)) {
    BytesReader reader(entry->bytes);
    reader.go_to(newest.offset);
    static_cast<void>(tables_.read(reader, unit));
  }
  compare(unit, found, newest.entry);
}

// Some of the units whose newest digest is known now, in a view that has no later entry. False:
// that was all.
bool ChainCheck::compare_more() {
  if (!compared_) compared_.emplace();
  // Those that changed since they were compared; they are counted already.
  const auto units = report_.units, rows = report_.rows;
  for (const NamedUnit& one : again_) compare_newest(one);
  again_.clear();
  report_.units = units;
  report_.rows = rows;
  int left = kUnitsPerStep;
  if (!all_compared_) {
    const auto some = newest_.after(compared_->kind, compared_->key, left);
    for (const NamedUnit& one : some) compare_newest(one);
    if (!some.empty()) compared_ = Place{some.back().kind, some.back().key};
    all_compared_ = std::ssize(some) < left;
    left -= static_cast<int>(std::ssize(some));
  }
  if (all_compared_) search_more(left);
  return left <= 0;
}

// Rows of the kinds that do not only grow which no entry names.
void ChainCheck::search_more(int& left) {
  for (; left > 0 && search_.kind < unit_kinds().size(); ++search_.kind, search_.table = 0) {
    const UnitKind& kind = unit_kinds()[search_.kind];
    if (kind.grows) continue;
    for (; search_.table < kind.tables.size(); ++search_.table, search_.key.clear()) {
      const auto keys = tables_.keys_after(kind, search_.table, search_.key, left);
      for (const std::string& key : keys)
        if (!newest_.holds(kind.number, key) && !tables_.is_before(kind, search_.table, key))
          report_inserted(kind, key);
      if (std::ssize(keys) == left) {
        search_.key = keys.back();
        left = 0;
        return;
      }
      left -= static_cast<int>(std::ssize(keys));
    }
  }
}

void ChainCheck::check_rest(const UnitKind& kind) {
  if (!kind.grows) return;
  auto& last = last_key_[kind.number];
  for (auto next = tables_.next_key(kind, last); next; next = tables_.next_key(kind, last)) {
    std::string key;
    add_integer(key, *next);
    report_inserted(kind, key);
    last = *next;
  }
}

void ChainCheck::check_end(const ChainEntry& newest) {
  for (const UnitKind& kind : unit_kinds()) check_rest(kind);
  for (auto& sentence : thinned_.differences(since_[kReadingKind])) tell(std::move(sentence));
  thinned_.tell(db_, report_);
  if (newest.number > 0) report_.head = {newest.number, digest::hex_from(newest.head)};
  if (outside_ && outside_->entry > newest.number)
    tell(entry_text(outside_->entry) + ", whose head was kept, is missing: the newest is " +
         std::to_string(newest.number) + "; what was stored after it is lost or was removed");
}

}  // namespace driftwise::storage
