#include "storage/chain/chain_recorder.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "server/core/reasons.h"
#include "storage/chain/chain_rows.h"
#include "storage/chain/thinned_entry.h"
#include "storage/chain/value_bytes.h"

namespace driftwise::storage {
namespace {

constexpr std::size_t kMostUnitsPerEntry = 500;

}  // namespace

ChainRecorder::ChainRecorder(Database& db, ProtectedTables& tables) : db_(db), tables_(tables) {
  sqlite3_preupdate_hook(db_.handle(), &ChainRecorder::changed, this);
}

ChainRecorder::~ChainRecorder() {
  if (db_.handle()) sqlite3_preupdate_hook(db_.handle(), nullptr, nullptr);
}

void ChainRecorder::changed(void* self, sqlite3* db, int operation, const char* database,
                            const char* table, sqlite3_int64, sqlite3_int64) {
  auto& recorder = *static_cast<ChainRecorder*>(self);
  if (std::strcmp(database, "main") != 0) return;
  const auto* place = recorder.tables_.place_of(table);
  if (place == nullptr) return;
  const auto touched = [&](auto&& value_at) -> Touched& {
    recorder.key_.clear();
    for (const int column : place->key_columns) {
      sqlite3_value* value = nullptr;
      if (value_at(db, column, &value) == SQLITE_OK) add_value(recorder.key_, value);
    }
    return recorder.touch(*place->kind, recorder.key_);
  };
  if (place->kind->grows) {
    if (operation == SQLITE_INSERT)
      recorder.take(*place, touched(sqlite3_preupdate_new));
    else if (operation != SQLITE_DELETE || !recorder.may_go(*place))
      recorder.refused_ = table;
    return;
  }
  if (operation != SQLITE_INSERT) touched(sqlite3_preupdate_old);
  if (operation != SQLITE_DELETE) touched(sqlite3_preupdate_new);
}

bool ChainRecorder::may_go(const ProtectedTables::Place& place) {
  if (place.kind->number != kReadingKind || thinned_keys_.empty()) return false;
  key_.clear();
  sqlite3_value* value = nullptr;
  if (sqlite3_preupdate_old(db_.handle(), place.key_columns.front(), &value) == SQLITE_OK)
    add_value(key_, value);
  return thinned_keys_.contains(key_);
}

std::string ChainRecorder::thin(std::int64_t thinning, std::span<const std::int64_t> readings) {
  digest::Sha256 sha;
  sha.begin();
  for (const std::int64_t reading : readings) {
    std::string key;
    add_integer(key, reading);
    sha.add(tables_.load(*unit_kind(kReadingKind), key).digest);
    thinned_keys_.insert(std::move(key));
  }
  std::string hash = sha.finish();
  thinned_entry_ = thinned_bytes(thinning, readings, hash);
  return hash;
}

ChainRecorder::Touched& ChainRecorder::touch(const UnitKind& kind, std::string_view key) {
  if (!touched_.empty() && touched_.back().kind == &kind && touched_.back().key == key)
    return touched_.back();
  id_.clear();
  add_integer(id_, kind.number);
  id_ += key;
  const auto [known, is_new] = known_.try_emplace(id_, touched_.size());
  if (is_new) touched_.push_back({&kind, std::string(key), {}});
  return touched_[known->second];
}

void ChainRecorder::take(const ProtectedTables::Place& place, Touched& unit) {
  NewRow row{place.number, 0, new_bytes_.size(), 0};
  sqlite3_value* value = nullptr;
  for (const int column : place.stored)
    if (sqlite3_preupdate_new(db_.handle(), column, &value) == SQLITE_OK)
      add_value(new_bytes_, value);
  row.length = new_bytes_.size() - row.offset;
  if (!place.rest.empty() &&
      sqlite3_preupdate_new(db_.handle(), place.rest.front(), &value) == SQLITE_OK)
    row.order = sqlite3_value_int64(value);
  unit.rows.push_back(row);
}

Unit ChainRecorder::unit_of(Touched& touched) {
  if (!touched.kind->grows) return tables_.load(*touched.kind, touched.key);
  std::ranges::sort(touched.rows, [](const NewRow& a, const NewRow& b) {
    return std::pair(a.table, a.order) < std::pair(b.table, b.order);
  });
  Unit unit;
  tables_.begin(unit, *touched.kind, touched.key);
  for (const NewRow& row : touched.rows) {
    std::string rest_key;
    if (row.table > 0) add_integer(rest_key, row.order);
    tables_.add_row(unit, row.table, std::move(rest_key),
                    std::string_view(new_bytes_).substr(row.offset, row.length));
  }
  tables_.finish(unit);
  return unit;
}

void ChainRecorder::at_commit() {
  if (!refused_.empty())
    throw_failure(ErrorCode::internal, reasons::kRowsNeverChange,
                  "rows of table " + refused_ +
                      " are never changed or deleted, and a call wanted to: nothing was stored; "
                      "please report this");
  std::string bytes;
  std::size_t units = 0;
  for (Touched& one : touched_) {
    add_unit(bytes, unit_of(one));
    if (++units % kMostUnitsPerEntry != 0) continue;
    append_entry(db_, sha_, chain_entry::kRows, bytes);
    bytes.clear();
  }
  if (!bytes.empty()) append_entry(db_, sha_, chain_entry::kRows, bytes);
  if (!thinned_entry_.empty()) append_entry(db_, sha_, chain_entry::kThinned, thinned_entry_);
  rolled_back();
}

void ChainRecorder::rolled_back() {
  touched_.clear();
  known_.clear();
  new_bytes_.clear();
  refused_.clear();
  thinned_keys_.clear();
  thinned_entry_.clear();
}

void ChainRecorder::begin() {
  std::vector<const UnitKind*> others;
  for (const UnitKind& kind : unit_kinds())
    if (newest_layout(db_, kind.number).text != tables_.layout(kind)) others.push_back(&kind);
  if (others.empty()) return;
  Transaction transaction(db_);
  for (const UnitKind* kind : others) {
    append_entry(db_, sha_, chain_entry::kLayout, tables_.layout(*kind));
    append_all(*kind);
  }
  transaction.commit();
}

void ChainRecorder::append_all(const UnitKind& kind) {
  std::string bytes;
  std::size_t units = 0;
  const auto append = [&](const std::string& key) {
    add_unit(bytes, tables_.load(kind, key));
    if (++units % kMostUnitsPerEntry != 0) return;
    append_entry(db_, sha_, chain_entry::kBegin, bytes);
    bytes.clear();
  };
  if (kind.grows) {
    for (auto next = tables_.next_key(kind, ProtectedTables::kBelowAllKeys); next;
         next = tables_.next_key(kind, *next)) {
      std::string key;
      add_integer(key, *next);
      append(key);
    }
  } else {
    for (const auto& key : tables_.keys(kind)) append(key);
  }
  if (!bytes.empty()) append_entry(db_, sha_, chain_entry::kBegin, bytes);
}

}  // namespace driftwise::storage
