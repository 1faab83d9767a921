#pragma once
// Backups of the record while the cell works: made when somebody asks and by the cell file's
// schedule, verified before they have their name, the oldest removed. Beside each stands the head
// of the chain in a text file.
//
// Several cells may keep theirs in one folder: the name has the identity of the record, as
// "cell-0f3a9c1d2e4b5061-20261122-093000.db", and one without it (of an earlier program) is asked
// for it. Only those of this record are counted and removed.
//
// Executor's thread; the folder is read and written on the thread of the database's checks.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/alarm_condition.h"
#include "server/application/ports/caller.h"
#include "server/application/upkeep/disk_forecast.h"
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
  // Also of a folder that does not answer, as of a server that is gone.
  std::vector<AlarmCondition> conditions() const;
  // Is the folder on the database's disk? Every now and then.
  Awaitable<void> look_at_folder();
  // Bytes of its folder and what the schedule will still put there; nothing where the folder was on
  // another disk than the database. None: not known yet.
  struct OnDisk {
    std::int64_t bytes = 0;
    CopiesToCome to_come;
  };
  std::optional<OnDisk> on_disk_of_database() const;
  // What a copy that was killed left in the folder goes; called once, before the first look.
  Awaitable<void> remove_unfinished();

 private:
  // What follows is of the reader's thread.
  struct Present {
    std::string identity;            // of the record
    std::vector<std::string> paths;  // oldest first; before them those whose instant is to come
  };
  Result<Present> present(Store& store, UtcTime now);
  std::vector<std::string> remove_oldest(Store& store, UtcTime now);
  void remove_parts(Store& store, const std::string& identity);
  bool is_own(Store& store, const std::string& path, const std::string& identity);

  bool is_beside_database();
  Result<void> check_room() const;
  std::string folder() const;
  std::string stem() const;
  UtcTime utc_now() const { return clock_.utc(clock_.now().utc); }

  Clock& clock_;
  std::string database_;
  BackupRules rules_;
  StoreReader& reader_;
  EventLog& events_;
  std::function<bool()> gives_way_;
  std::map<std::string, std::string> identities_;  // of copies without it in their name, by path
  bool under_way_ = false;
  // The folder is on the database's disk: only then is it safe to read it on the executor, for a
  // folder elsewhere may be a server's that does not answer. None: nobody has looked.
  std::optional<bool> beside_database_;
  // When the look that has not come back began; 0: none is under way. Set on the reader's thread.
  std::atomic<std::int64_t> looking_since_ns_ = 0;
  std::size_t present_ = 0;  // copies by the last look at the schedule
  CellTime next_try_;
  std::string failed_;  // why the last one by the schedule was not made
};

}  // namespace driftwise::application
