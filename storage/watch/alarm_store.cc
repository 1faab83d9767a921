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

// Whoever watches hears of every open alarm of the condition.
void number_change(Session& session, const std::string& kind, const std::string& subject) {
  std::vector<std::int64_t> ids;
  Query open(session.db,
             "SELECT alarm_id FROM alarm WHERE kind = ? AND subject = ? AND (cleared_ns = 0 OR "
             "acknowledged_ns = 0)");
  open.bind(kind, subject);
  while (open.row()) ids.push_back(open.integer(0));
  for (const std::int64_t id : ids)
    Query(session.db,
          "UPDATE alarm SET change = (SELECT max(change) + 1 FROM alarm) WHERE alarm_id = ?")
        .bind(id)
        .run();
}

void end_shelf(Session& session, const std::string& kind, const std::string& subject, CellTime at) {
  Query(session.db,
        "UPDATE alarm_shelf SET ended_ns = ?3 WHERE kind = ?1 AND subject = ?2 AND ended_ns = 0")
      .bind(kind, subject, at.utc_ns)
      .run();
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
  alarm.shelved_until = {row.integer(10)};
  alarm.shelved_by = row.text(11);
  alarm.shelve_reason = row.text(12);
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
    // Alarms that hold are cut off last; the list is newest first all the same.
    Query standing(session_.db, "SELECT * FROM (" DRIFTWISE_SELECT_ALARM
                                " WHERE cleared_ns = 0 OR acknowledged_ns = 0 ORDER BY cleared_ns "
                                "<> 0, alarm_id DESC LIMIT ?) ORDER BY alarm_id DESC");
    Query& query = with_history ? all : standing;
    query.bind(limit > 0 ? limit : -1);
    std::vector<AlarmRecord> alarms;
    while (query.row()) alarms.push_back(alarm_from(query));
    return alarms;
  });
}

Result<AlarmRecord> SqliteAlarmStore::shelve(AlarmId id, const AlarmShelf& shelf) {
  return session_.write([&] {
    const AlarmRecord alarm = read_alarm(session_, id);
    end_shelf(session_, alarm.kind, alarm.subject, shelf.at);
    Query(session_.db,
          "INSERT INTO alarm_shelf (kind, subject, at_ns, until_ns, who, reason, ended_ns) VALUES "
          "(?, ?, ?, ?, ?, ?, 0)")
        .bind(alarm.kind, alarm.subject, shelf.at.utc_ns, shelf.until.utc_ns, shelf.who,
              clean_line(shelf.reason))
        .run();
    number_change(session_, alarm.kind, alarm.subject);
    return read_alarm(session_, id);
  });
}

Result<AlarmRecord> SqliteAlarmStore::unshelve(AlarmId id, CellTime at) {
  return session_.write([&] {
    const AlarmRecord alarm = read_alarm(session_, id);
    end_shelf(session_, alarm.kind, alarm.subject, at);
    number_change(session_, alarm.kind, alarm.subject);
    return read_alarm(session_, id);
  });
}

Result<std::vector<AlarmRecord>> SqliteAlarmStore::end_shelves(CellTime now) {
  return session_.write([&] {
    std::vector<std::pair<std::string, std::string>> over;
    Query due(session_.db,
              "SELECT kind, subject FROM alarm_shelf WHERE ended_ns = 0 AND until_ns <= ?");
    due.bind(now.utc_ns);
    while (due.row()) over.emplace_back(due.text(0), due.text(1));
    std::vector<AlarmRecord> back;
    for (const auto& [kind, subject] : over) {
      end_shelf(session_, kind, subject, now);
      number_change(session_, kind, subject);
      Query alarms(session_.db, DRIFTWISE_SELECT_ALARM
                   " WHERE alarm.kind = ? AND alarm.subject = ? AND (cleared_ns = 0 OR "
                   "acknowledged_ns = 0)");
      alarms.bind(kind, subject);
      while (alarms.row()) back.push_back(alarm_from(alarms));
    }
    return back;
  });
}

}  // namespace driftwise::storage
