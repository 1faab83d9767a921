#pragma once
// The chain as it is written: SQLite's pre-update hook says which protected rows a transaction
// changes, and right before its commit one entry with their digests is appended. So nothing that
// writes through this connection can forget the chain. Rows of the kinds that grow, which are most
// of them, are taken as they pass the hook; others are read back.
//
// Thread: the store's.

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "storage/chain/protected_tables.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class ChainRecorder final : public AtCommit {
 public:
  ChainRecorder(Database& db, ProtectedTables& tables);
  ~ChainRecorder() override;
  ChainRecorder(const ChainRecorder&) = delete;
  ChainRecorder& operator=(const ChainRecorder&) = delete;

  // After the schema is up to date: begins the chain over what is there, in one transaction, and
  // again for those tables whose columns are others now. Throws StorageFailure.
  void begin();

  void at_commit() override;
  void rolled_back() override;
  std::string thin(std::int64_t thinning, std::span<const std::int64_t> readings) override;

 private:
  struct NewRow {
    int table;
    std::int64_t order;  // the rest of its primary key
    std::size_t offset, length;
  };
  struct Touched {
    const UnitKind* kind;
    std::string key;
    std::vector<NewRow> rows;  // of a kind that grows
  };

  static void changed(void* self, sqlite3* db, int operation, const char* database,
                      const char* table, sqlite3_int64 before, sqlite3_int64 after);
  Touched& touch(const UnitKind& kind, std::string_view key);
  void take(const ProtectedTables::Place& place, Touched& unit);
  bool may_go(const ProtectedTables::Place& place);  // the row that is being deleted
  Unit unit_of(Touched& touched);
  void append_all(const UnitKind& kind);

  Database& db_;
  ProtectedTables& tables_;
  digest::Sha256 sha_;
  std::vector<Touched> touched_;
  std::unordered_map<std::string, std::size_t> known_;  // by the kind's number and key, as bytes
  std::string new_bytes_;                               // of the rows taken
  std::string key_, id_;
  std::string refused_;  // a table whose rows never change, and one was changed
  // Of a thinning: what may be deleted, and its entry of the chain.
  std::unordered_set<std::string> thinned_keys_;
  std::string thinned_entry_;
};

}  // namespace driftwise::storage
