#include "storage/watch/outbox_store.h"

#include "server/core/text/clean_text.h"
#include "storage/watch/alarm_store.h"

namespace driftwise::storage {
namespace {

#define DRIFTWISE_SELECT_TELLING                                                                \
  "SELECT alarm_id, receiver, firing_ns, last_ns, resolved_ns, count, failed, tried_ns, error " \
  "FROM telling"

TellingRecord telling_from(const Query& row) {
  TellingRecord telling;
  telling.alarm = {row.integer(0)};
  telling.receiver = row.text(1);
  telling.firing = {row.integer(2)};
  telling.last = {row.integer(3)};
  telling.resolved = {row.integer(4)};
  telling.count = row.integer(5);
  telling.failed = row.integer(6);
  telling.tried = {row.integer(7)};
  telling.error = row.text(8);
  return telling;
}

}  // namespace

Result<OpenTellings> SqliteOutboxStore::open(std::span<const std::string> receivers, CellTime now,
                                             CellTime over_after) {
  return session_.write([&] {
    OpenTellings open;
    for (const auto& name : receivers) {
      Query(session_.db,
            "INSERT INTO receiver (name, known_since_ns) VALUES (?, ?) ON CONFLICT DO NOTHING")
          .bind(name, now.utc_ns)
          .run();
      Query known(session_.db, "SELECT known_since_ns FROM receiver WHERE name = ?");
      if (known.bind(name).row()) open.receivers.push_back({name, {known.integer(0)}});
    }
    Query alarms(session_.db, DRIFTWISE_SELECT_ALARM
                 " WHERE cleared_ns = 0 OR cleared_ns > ? ORDER BY alarm_id");
    alarms.bind(over_after.utc_ns);
    while (alarms.row()) open.alarms.push_back(alarm_from(alarms));
    Query tellings(session_.db, DRIFTWISE_SELECT_TELLING
                   " WHERE alarm_id IN (SELECT alarm_id FROM alarm WHERE cleared_ns = 0 OR "
                   "cleared_ns > ?)");
    tellings.bind(over_after.utc_ns);
    while (tellings.row()) open.tellings.push_back(telling_from(tellings));
    return open;
  });
}

Result<void> SqliteOutboxStore::put(std::span<const TellingRecord> tellings) {
  return session_.write([&] {
    for (const auto& one : tellings)
      Query(session_.db,
            "INSERT OR REPLACE INTO telling (alarm_id, receiver, firing_ns, last_ns, resolved_ns, "
            "count, failed, tried_ns, error) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
          .bind(one.alarm, one.receiver, one.firing.utc_ns, one.last.utc_ns, one.resolved.utc_ns,
                one.count, one.failed, one.tried.utc_ns, clean_line(one.error))
          .run();
  });
}

Result<std::vector<TellingRecord>> SqliteOutboxStore::tellings(int limit) {
  return session_.read([&] {
    Query query(session_.db, DRIFTWISE_SELECT_TELLING " ORDER BY alarm_id DESC, receiver LIMIT ?");
    query.bind(limit > 0 ? limit : -1);
    std::vector<TellingRecord> tellings;
    while (query.row()) tellings.push_back(telling_from(query));
    return tellings;
  });
}

}  // namespace driftwise::storage
