#pragma once
// Backups of the record while the cell works: made when somebody asks and by the cell file's
// schedule, verified before they have their name, the oldest removed. Beside each stands the head
// of the chain in a text file.
//
// Executor's thread; the copy itself is made on the thread of the database's checks.

#include <functional>
#include <string>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/alarm_condition.h"
#include "server/application/ports/caller.h"
#include "server/core/description/backup_rules.h"
#include "server/core/ports/clock.h"
#include "server/core/records/copy_records.h"

namespace driftwise::application {

class Backups {
 public:
  // gives_way: asked on the thread of the copy; true ends it.
  Backups(Clock& clock, std::string database, BackupRules rules, StoreReader& reader,
          EventLog& events, std::function<bool()> gives_way);

  // by: nullptr for the schedule.
  Awaitable<Result<RecordCopy>> make(const Caller* by);
  // By the schedule, where one is due; called every now and then.
  Awaitable<void> make_if_due();
  std::vector<AlarmCondition> conditions() const;
  // Paths, oldest first; before them all those whose instant is still to come.
  std::vector<std::string> present() const;

 private:
  std::string folder() const;
  std::string stem() const;
  std::string instant_in(const std::string& path) const;  // "20261122-093000"
  void remove_oldest();

  Clock& clock_;
  std::string database_;
  BackupRules rules_;
  StoreReader& reader_;
  EventLog& events_;
  std::function<bool()> gives_way_;
  bool under_way_ = false;
  CellTime next_try_;
  std::string failed_;  // why the last one by the schedule was not made
};

}  // namespace driftwise::application
