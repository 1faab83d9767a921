#pragma once
// Care for the database while the cell works: watches its files, replaces a lost log, copies a
// record whose file was taken away, and checks the stored pages table by table when there is time.
//
// Executor's thread, as the rest; the check itself runs on a thread and a read-only connection of
// its own. Source of the rules: docs/database.md.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/application/ports/database_health.h"
#include "server/application/upkeep/backups.h"
#include "server/application/upkeep/disk_forecast.h"
#include "server/application/upkeep/record_keeping.h"
#include "server/core/description/thinning_rules.h"

namespace driftwise::application {

class DatabaseUpkeep final : public RecordKeeping {
 public:
  static constexpr double kLook_s = 2;           // cell time between two looks at the files
  static constexpr double kMeasure_s = 600;      // between two looks at the size and the disk
  static constexpr double kKeepAgain_s = 60;     // between two tries of a copy that fails
  static constexpr double kThinEvery_s = 86400;  // between two thinnings by the cell file
  static constexpr double kFirstCheck_s = 60;    // after the start: the cell comes first
  static constexpr double kPassEvery_s = 86400;  // between the ends of two passes
  // A check holds its view of the database, and the log grows meanwhile: above this it gives way.
  static constexpr std::int64_t kMostLogBytes = 64 << 20;

  // readers: the other read-only stores, which must let go while the log is replaced. checker: one
  // for the checks alone, on a thread that nobody else uses; none: nothing is checked. busy: the
  // robot is at work, which a check waits for, for a day at most.
  DatabaseUpkeep(asio::any_io_executor executor, Clock& clock, std::string path,
                 StoreWriter& writer, std::vector<StoreReader*> readers, StoreReader* checker,
                 EventLog& events, TaskGroup& tasks, std::function<bool()> busy,
                 BackupRules backups, ThinningRules thinning);

  void start();
  void shut_down();

  Awaitable<Result<ChainReport>> verify(std::optional<ChainHead> kept) override;
  Awaitable<Result<RecordCopy>> back_up(Caller caller) override;
  Awaitable<Result<ThinningStep>> thin(ThinningOrder order, Caller caller) override;

  std::vector<AlarmCondition> conditions() const;
  const DatabaseHealth& health() const { return health_; }
  // Of the database's disk, 1e9 bytes, as measured last; none: not since two periods of it.
  std::optional<double> disk_free_gb() const;

 private:
  Awaitable<void> watch();
  Awaitable<void> keep_measured();
  Awaitable<void> keep_backups();
  Awaitable<void> keep_thin();
  // done: what was done, also before a failure; it outlives the call.
  Awaitable<Result<void>> thin_in_steps(ThinningOrder order, ThinningStep& done);
  void measure();
  Awaitable<void> look();
  Awaitable<void> replace_log();
  Awaitable<void> open_again();  // every connection
  Awaitable<void> resume_readers();
  std::vector<StoreReader*> all_readers() const;
  bool any_reader_waits() const;
  void tell_of_log(const std::string& outcome);
  Awaitable<void> keep_copy();
  void list_troubles();
  Awaitable<void> check();
  Awaitable<void> first_look();
  Awaitable<bool> check_next_table();  // false: the pass is over
  std::int64_t log_bytes() const;
  std::string copy_path() const;

  asio::any_io_executor executor_;
  Clock& clock_;
  std::string path_;
  StoreWriter& writer_;
  std::vector<StoreReader*> readers_;
  StoreReader* checker_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::function<bool()> busy_;
  DatabaseFiles files_ = DatabaseFiles::good;
  std::string files_message_;
  bool kept_ = false;    // the record that is held open was copied
  CellTime keep_again_;  // when a copy that failed is due again
  CellTime log_lost_;    // when a log was last lost, utc_ns 0: never
  std::string log_message_;
  Result<void> secured_, reopened_;
  std::string reader_message_;  // why queries wait; empty: they do not
  std::string first_trouble_;   // of the first look
  DatabaseHealth health_;
  DatabaseChecks checks_;
  std::atomic<bool> gives_way_{false};  // asked by the checker's thread
  Backups backups_;
  ThinningRules thinning_;
  bool thinning_under_way_ = false;
  DiskForecast forecast_;
  std::optional<double> disk_free_gb_;
  CellTime disk_looked_at_;
  Signal ended_;
  bool ending_ = false;
};

}  // namespace driftwise::application
