#include "storage/chain/newest_units.h"

#include "storage/sqlite/failure.h"

namespace driftwise::storage {
namespace {

template <class F>
auto in_temporary_file(F&& body) {
  try {
    return body();
  } catch (StorageFailure& failure) {
    failure.error.message =
        "the check keeps what the chain says of each unit in a temporary file (in $TMPDIR, or "
        "/var/tmp), which failed: " +
        failure.error.message;
    throw;
  }
}

}  // namespace

// No name: a file that is deleted already. What is kept in memory of it: 4 MB.
NewestUnits::NewestUnits() : db_("", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "") {
  in_temporary_file([this] {
    db_.execute(
        "PRAGMA cache_size = -4000; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; "
        "CREATE TABLE unit (kind INTEGER NOT NULL, key BLOB NOT NULL, entry INTEGER NOT NULL, "
        "offset INTEGER NOT NULL, digest BLOB NOT NULL, PRIMARY KEY (kind, key)) STRICT, WITHOUT "
        "ROWID; BEGIN");
  });
}

void NewestUnits::put(const NamedUnit& unit) {
  in_temporary_file([&] {
    Query(db_,
          "INSERT INTO unit (kind, key, entry, offset, digest) VALUES (?, ?, ?, ?, ?) ON CONFLICT "
          "DO UPDATE SET entry = excluded.entry, offset = excluded.offset, digest = "
          "excluded.digest")
        .bind(unit.kind, Bytes{unit.key}, unit.entry, static_cast<std::int64_t>(unit.offset),
              Bytes{unit.digest})
        .run();
  });
}

bool NewestUnits::holds(int kind, std::string_view key) {
  return in_temporary_file([&] {
    Query query(db_, "SELECT 1 FROM unit WHERE kind = ? AND key = ?");
    return query.bind(kind, Bytes{key}).row();
  });
}

std::vector<NamedUnit> NewestUnits::after(int kind, std::string_view key, int limit) {
  return in_temporary_file([&] {
    Query query(db_,
                "SELECT kind, key, entry, offset, digest FROM unit WHERE (kind, key) > (?, ?) "
                "ORDER BY kind, key LIMIT ?");
    query.bind(kind, std::string_view(), limit);
    if (!key.empty()) query.bind(kind, Bytes{key}, limit);
    std::vector<NamedUnit> found;
    while (query.row())
      found.push_back({static_cast<int>(query.integer(0)), query.bytes(1), query.integer(2),
                       static_cast<std::size_t>(query.integer(3)), query.bytes(4)});
    return found;
  });
}

}  // namespace driftwise::storage
