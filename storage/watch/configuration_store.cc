#include "storage/watch/configuration_store.h"

#include "server/core/reasons.h"
#include "storage/rows/run_rows.h"
#include "storage/rows/run_select.h"

namespace driftwise::storage {
namespace {

ConfigurationStart start_from(const Query& row) {
  ConfigurationStart start;
  start.id = row.integer(0);
  start.hash = row.text(1);
  start.before_hash = row.text(2);
  start.changes_json = row.text(3);
  start.asks = row.integer(4) != 0;
  start.version = row.text(5);
  start.at = {{row.integer(6)}, row.integer(7)};
  start.accepted = {row.integer(8)};
  start.accepted_by = row.text(9);
  start.note = row.text(10);
  return start;
}

ConfigurationStart read_start(Session& session, std::int64_t id) {
  Query query(session.db,
              "SELECT start_id, config_hash, before_hash, changes_json, asks, version, at_ns, "
              "at_monotonic_ns, accepted_ns, accepted_by, note FROM configuration_start "
              "WHERE start_id = ?");
  if (!query.bind(id).row())
    throw_failure(ErrorCode::not_found, reasons::kNoSuchConfiguration,
                  "there is no start " + std::to_string(id) + " in database " + session.db.path());
  return start_from(query);
}

std::vector<UsedConfiguration> used_by(Session& session, RunId run) {
  std::vector<UsedConfiguration> used;
  Query first(session.db, "SELECT " DRIFTWISE_CELL_FILE_OF_RUN
                          ", created_ns FROM run JOIN run_progress USING (run_id) "
                          "WHERE run_id = ?");
  if (!first.bind(run).row()) throw_no_such_run(session, run);
  if (first.text(0).empty()) return used;
  used.push_back({first.text(0), {first.integer(1)}});
  Query later(
      session.db,
      "SELECT config_hash, from_ns FROM run_configuration WHERE run_id = ? ORDER BY position");
  later.bind(run);
  while (later.row()) used.push_back({later.text(0), {later.integer(1)}});
  return used;
}

void insert_used(Session& session, RunId run, const UsedConfiguration& used) {
  const auto before = used_by(session, run);
  if (before.empty() || before.back().hash == used.hash) return;
  Query(session.db,
        "INSERT INTO run_configuration (run_id, position, config_hash, from_ns) "
        "VALUES (?, ?, ?, ?)")
      .bind(run, static_cast<std::int64_t>(before.size()), used.hash, used.from.utc_ns)
      .run();
}

}  // namespace

Result<ConfigurationStart> SqliteConfigurationStore::begin(const ConfigurationStart& start,
                                                           const std::string& text) {
  return session_.write([&] {
    Query(session_.db, "INSERT OR IGNORE INTO cell_config (hash, text) VALUES (?, ?)")
        .bind(start.hash, text)
        .run();
    Query(session_.db,
          "INSERT INTO configuration_start (config_hash, before_hash, changes_json, asks, version, "
          "at_ns, at_monotonic_ns, accepted_ns, accepted_by, note) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, 0, '', '')")
        .bind(start.hash, start.before_hash, start.changes_json, start.asks ? 1 : 0, start.version,
              start.at.utc.utc_ns, start.at.monotonic_ns)
        .run();
    return read_start(session_, session_.db.last_row_id());
  });
}

Result<std::optional<std::string>> SqliteConfigurationStore::accepted_hash() {
  return session_.read([&]() -> std::optional<std::string> {
    Query settled(session_.db,
                  "SELECT config_hash FROM configuration_start WHERE asks = 0 OR accepted_ns <> 0 "
                  "ORDER BY start_id DESC LIMIT 1");
    if (settled.row()) return settled.text(0);
    Query newest(session_.db, "SELECT config_hash FROM run ORDER BY run_id DESC LIMIT 1");
    if (newest.row()) return newest.text(0);
    return std::nullopt;
  });
}

Result<std::vector<ConfigurationStart>> SqliteConfigurationStore::starts(int limit) {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT start_id, config_hash, before_hash, changes_json, asks, version, at_ns, "
                "at_monotonic_ns, accepted_ns, accepted_by, note FROM configuration_start "
                "ORDER BY start_id DESC LIMIT ?");
    query.bind(limit);
    std::vector<ConfigurationStart> starts;
    while (query.row()) starts.push_back(start_from(query));
    return starts;
  });
}

Result<std::string> SqliteConfigurationStore::text(const std::string& hash) {
  return session_.read([&] {
    Query query(session_.db, "SELECT text FROM cell_config WHERE hash = ?");
    if (!query.bind(hash).row())
      throw_failure(ErrorCode::not_found, reasons::kNoSuchConfiguration,
                    "no cell file with hash " + hash + " was ever in force on database " +
                        session_.db.path() +
                        ": 'driftwise configuration list' shows those that were");
    return query.text(0);
  });
}

Result<ConfigurationStart> SqliteConfigurationStore::accept(std::int64_t id, CellTime at,
                                                            const std::string& who,
                                                            const std::string& note,
                                                            std::optional<RunId> continued) {
  return session_.write([&] {
    const auto start = read_start(session_, id);
    if (!start.is_open())
      throw_failure(ErrorCode::failed_precondition, reasons::kNoQuestion,
                    start.asks ? "configuration " + start.hash + " was accepted by " +
                                     start.accepted_by + " already"
                               : "configuration " + start.hash + " puts no question");
    Query(session_.db,
          "UPDATE configuration_start SET accepted_ns = ?, accepted_by = ?, note = ? "
          "WHERE start_id = ?")
        .bind(at.utc_ns, who, note, id)
        .run();
    if (continued) insert_used(session_, *continued, {start.hash, at});
    return read_start(session_, id);
  });
}

Result<void> SqliteConfigurationStore::continue_run(RunId run, const UsedConfiguration& used) {
  return session_.write([&] { insert_used(session_, run, used); });
}

Result<std::vector<UsedConfiguration>> SqliteConfigurationStore::of_run(RunId run) {
  return session_.read([&] { return used_by(session_, run); });
}

}  // namespace driftwise::storage
