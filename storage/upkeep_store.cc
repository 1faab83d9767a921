#include "storage/upkeep_store.h"

#include "server/core/reasons.h"
#include "storage/audit/record_copy.h"
#include "storage/sqlite/gives_way.h"

namespace driftwise::storage {
namespace {

constexpr int kTroublesTold = 3;
constexpr int kNewestPoints = 100;

std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

// Every row of a statement, read to its last byte.
void read_through(Database& db, const char* sql) {
  Query query(db, sql);
  while (query.row())
    for (int column = 0; column < query.columns(); ++column) static_cast<void>(query.text(column));
}

std::string first_look(Database& db) {
  static_cast<void>(db.pragma("application_id"));
  read_through(db, "SELECT sql FROM sqlite_schema");
  read_through(db,
               "SELECT * FROM cell_config WHERE hash IN (SELECT config_hash FROM run ORDER BY "
               "run_id DESC LIMIT 3)");
  read_through(db, "SELECT * FROM run ORDER BY run_id DESC LIMIT 3");
  static_assert(kNewestPoints == 100, "as in the statements below");
  read_through(db, "SELECT * FROM point ORDER BY point_id DESC LIMIT 100");
  read_through(db,
               "SELECT v.* FROM (SELECT point_id FROM point ORDER BY point_id DESC LIMIT 100) p "
               "JOIN point_value v USING (point_id)");
  read_through(db,
               "SELECT v.* FROM (SELECT reading_id FROM reading ORDER BY reading_id DESC LIMIT "
               "100) r JOIN reading_value v USING (reading_id)");
  return {};
}

// What quick_check prints about a table; empty: "ok".
std::string quick_check(Database& db, const std::string& table) {
  std::string trouble;
  int told = 0;
  db.for_each_row("PRAGMA quick_check(" + quoted(table) + ")", [&](const std::string& line) {
    if (line == "ok" || ++told > kTroublesTold) return;
    trouble += (trouble.empty() ? "" : "; ") + line;
  });
  if (told > kTroublesTold) trouble += "; and " + std::to_string(told - kTroublesTold) + " more";
  return trouble;
}

}  // namespace

Result<void> SqliteUpkeepStore::secure() {
  return answered([this] { session_.secure_log(); });
}

Result<void> SqliteUpkeepStore::reopen() {
  return answered([this] {
    const DatabaseFiles state = session_.files.look();
    // Opening the path would make an empty record of the name, or take another file for this one.
    if (state == DatabaseFiles::moved || state == DatabaseFiles::replaced)
      throw StorageFailure{files_error(state, session_.db.path())};
    // A log that is on no path goes with the connection: what it holds has to be elsewhere first.
    if (session_.db.is_open() && state == DatabaseFiles::log_gone) session_.secure_log();
    session_.names.forget();
    session_.at_commit = nullptr;  // without the chain's recorder nothing is written
    try {
      session_.db.reopen();
      set_up_();
    } catch (...) {
      session_.at_commit = nullptr;
      session_.db.close();
      session_.files.wrote();  // closing moves the log into the database
      throw;
    }
  });
}

Result<void> SqliteUpkeepStore::copy_to(const std::string& path) {
  return answered([&] { rescue_record(session_.db, path); });
}

Result<std::vector<std::string>> SqliteUpkeepStore::tables() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0 ORDER BY "
                "name");
    std::vector<std::string> names;
    while (query.row()) names.push_back(query.text(0));
    return names;
  });
}

Result<std::string> SqliteUpkeepStore::check(const std::string& table,
                                             const std::function<bool()>& give_way) {
  GivesWay watch(session_.db, give_way);
  auto trouble = answered(
      [&] { return table.empty() ? first_look(session_.db) : quick_check(session_.db, table); });
  if (trouble) return trouble;
  if (watch.gave_way())
    return fail(ErrorCode::cancelled, reasons::kGaveWay,
                "the check of table " + table + " gave way");
  // A page that cannot be read at all is what the check is there to find.
  if (trouble.error().code == ErrorCode::data_loss) return trouble.error().message;
  return trouble;
}

Result<DatabaseChecks> SqliteUpkeepStore::checks() {
  return session_.read([&] {
    DatabaseChecks found;
    Query pass(session_.db, "SELECT begun_ns, last_clean_ns FROM database_check_pass");
    if (pass.row()) {
      found.begun.utc_ns = pass.integer(0);
      found.last_clean.utc_ns = pass.integer(1);
    }
    Query tables(session_.db,
                 "SELECT table_name, checked_ns, trouble FROM database_check ORDER BY table_name");
    while (tables.row())
      found.tables.push_back({tables.text(0), {tables.integer(1)}, tables.text(2)});
    return found;
  });
}

Result<void> SqliteUpkeepStore::keep_check(const TableCheck& check, CellTime begun,
                                           bool all_clean) {
  return session_.write([&] {
    Query(session_.db,
          "INSERT INTO database_check (table_name, checked_ns, trouble) VALUES (?, ?, ?) ON "
          "CONFLICT DO UPDATE SET checked_ns = excluded.checked_ns, trouble = excluded.trouble")
        .bind(check.table, check.checked.utc_ns, check.trouble)
        .run();
    Query(session_.db,
          "INSERT INTO database_check_pass (pass, begun_ns, last_clean_ns) VALUES (1, ?1, ?2) ON "
          "CONFLICT DO UPDATE SET begun_ns = ?1, last_clean_ns = CASE ?2 WHEN 0 THEN "
          "last_clean_ns ELSE ?2 END")
        .bind(begun.utc_ns, all_clean ? check.checked.utc_ns : std::int64_t{0})
        .run();
  });
}

}  // namespace driftwise::storage
