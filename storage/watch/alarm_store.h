#pragma once

#include "server/core/ports/watch_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Columns of an AlarmRecord, in one order for every query.
#define DRIFTWISE_SELECT_ALARM                                                                 \
  "SELECT alarm_id, level, alarm.kind, alarm.subject, message, since_ns, cleared_ns, "         \
  "acknowledged_ns, acknowledged_by, change, coalesce(until_ns, 0), coalesce(who, ''), "       \
  "coalesce(reason, '') FROM alarm LEFT JOIN alarm_shelf AS shelf ON shelf.kind = alarm.kind " \
  "AND shelf.subject = alarm.subject AND shelf.ended_ns = 0"
AlarmRecord alarm_from(const Query& row);

class SqliteAlarmStore final : public AlarmStore {
 public:
  explicit SqliteAlarmStore(Session& session) : session_(session) {}
  Result<AlarmRecord> raise(const AlarmRecord& alarm) override;
  Result<AlarmRecord> tell(AlarmId id, const std::string& message,
                           const std::vector<std::string>& consequences) override;
  Result<AlarmRecord> clear(AlarmId id, CellTime at) override;
  Result<AlarmRecord> acknowledge(AlarmId id, CellTime at, const std::string& who) override;
  // Alarms that hold are left out last where there are more than the limit, without history.
  Result<std::vector<AlarmRecord>> alarms(bool with_history, int limit) override;
  Result<AlarmRecord> shelve(AlarmId id, const AlarmShelf& shelf) override;
  Result<AlarmRecord> unshelve(AlarmId id, CellTime at) override;
  Result<std::vector<AlarmRecord>> end_shelves(CellTime now) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
