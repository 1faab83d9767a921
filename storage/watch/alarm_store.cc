#include "storage/watch/alarm_store.h"

#include <sstream>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise::storage {
namespace {

AlarmRecord read_alarm(Session& session, AlarmId id) {
  Query query(session.db, DRIFTWISE_SELECT_ALARM " WHERE alarm_id = ?");
  if (!query.bind(id).row())
    throw_failure(ErrorCode::not_found, reasons::kNoSuchAlarm,
                  "there is no alarm " + std::to_string(id.value) +
                      ": 'driftwise alarms --all' shows those there are");
  return alarm_from(query);
}

// One text: the sentence, then each consequence on a line of its own.
std::string stored_text(const std::string& message, const std::vector<std::string>& consequences) {
  std::string text = clean_line(message);
  for (const auto& one : consequences) text += "\n" + clean_line(one);
  return text;
}

}  // namespace

AlarmRecord alarm_from(const Query& row) {
  AlarmRecord alarm;
  alarm.id = {row.integer(0)};
  alarm.level = alarm_level_from(row.text(1)).value_or(AlarmLevel::warning);
  alarm.kind = row.text(2);
  alarm.subject = row.text(3);
  std::istringstream lines(row.text(4));
  std::getline(lines, alarm.message);
  for (std::string one; std::getline(lines, one);) alarm.consequences.push_back(one);
  alarm.since = {row.integer(5)};
  alarm.cleared = {row.integer(6)};
  alarm.acknowledged = {row.integer(7)};
  alarm.acknowledged_by = row.text(8);
  alarm.change = row.integer(9);
  return alarm;
}

Result<AlarmRecord> SqliteAlarmStore::raise(const AlarmRecord& alarm) {
  return session_.write([&] {
    Query(session_.db,
          "INSERT INTO alarm (level, kind, subject, message, since_ns, cleared_ns, "
          "acknowledged_ns, acknowledged_by, change) VALUES (?, ?, ?, ?, ?, ?, 0, '', "
          "(SELECT coalesce(max(change), 0) + 1 FROM alarm))")
        .bind(to_string(alarm.level), alarm.kind, alarm.subject,
              stored_text(alarm.message, alarm.consequences), alarm.since.utc_ns,
              alarm.cleared.utc_ns)
        .run();
    return read_alarm(session_, {session_.db.last_row_id()});
  });
}

Result<AlarmRecord> SqliteAlarmStore::tell(AlarmId id, const std::string& message,
                                           const std::vector<std::string>& consequences) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE alarm SET message = ?2, change = (SELECT max(change) + 1 FROM alarm) WHERE "
          "alarm_id = ?1 AND cleared_ns = 0")
        .bind(id, stored_text(message, consequences))
        .run();
    return read_alarm(session_, id);
  });
}

Result<AlarmRecord> SqliteAlarmStore::clear(AlarmId id, CellTime at) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE alarm SET cleared_ns = ?2, change = (SELECT max(change) + 1 FROM alarm) WHERE "
          "alarm_id = ?1 AND cleared_ns = 0")
        .bind(id, at.utc_ns)
        .run();
    return read_alarm(session_, id);
  });
}

Result<AlarmRecord> SqliteAlarmStore::acknowledge(AlarmId id, CellTime at, const std::string& who) {
  return session_.write([&] {
    Query(session_.db,
          "UPDATE alarm SET acknowledged_ns = ?2, acknowledged_by = ?3, change = (SELECT "
          "max(change) + 1 FROM alarm) WHERE alarm_id = ?1 AND acknowledged_ns = 0")
        .bind(id, at.utc_ns, who)
        .run();
    return read_alarm(session_, id);
  });
}

Result<std::vector<AlarmRecord>> SqliteAlarmStore::alarms(bool with_history, int limit) {
  return session_.read([&] {
    Query all(session_.db, DRIFTWISE_SELECT_ALARM " ORDER BY alarm_id DESC LIMIT ?");
    Query standing(session_.db, DRIFTWISE_SELECT_ALARM
                   " WHERE cleared_ns = 0 OR acknowledged_ns = 0 ORDER BY alarm_id DESC LIMIT ?");
    Query& query = with_history ? all : standing;
    query.bind(limit > 0 ? limit : -1);
    std::vector<AlarmRecord> alarms;
    while (query.row()) alarms.push_back(alarm_from(query));
    return alarms;
  });
}

}  // namespace driftwise::storage
