#include "storage/sqlite_store.h"

#include <chrono>

#include "server/core/try.h"
#include "storage/audit/audit_store.h"
#include "storage/audit/record_copy.h"
#include "storage/chain/chain_recorder.h"
#include "storage/diagnosis/diagnosis_store.h"
#include "storage/indentation/indentation_store.h"
#include "storage/models/model_store.h"
#include "storage/plans/plan_store.h"
#include "storage/readings/reading_store.h"
#include "storage/readings/series_store.h"
#include "storage/record_store.h"
#include "storage/runs/closure_store.h"
#include "storage/runs/queue_store.h"
#include "storage/runs/run_store.h"
#include "storage/runs/trajectory_store.h"
#include "storage/schema/schema.h"
#include "storage/sqlite/session.h"
#include "storage/sqlite/wide_views.h"
#include "storage/upkeep_store.h"
#include "storage/watch/alarm_store.h"
#include "storage/watch/clock_store.h"
#include "storage/watch/configuration_store.h"
#include "storage/watch/event_store.h"
#include "storage/watch/outbox_store.h"
#include "storage/watch/remark_store.h"
#include "storage/watch/rest_store.h"
#include "storage/watch/stop_store.h"

namespace driftwise::storage {
namespace {

// Figures behind these settings: docs/decisions/0003-readings-in-the-database.md.
constexpr int kForcedCheckpointFactor = 16;  // a log that nobody checkpoints stays below 64 MB
constexpr const char* kCommonPragmas =
    "PRAGMA foreign_keys = ON; PRAGMA trusted_schema = OFF; PRAGMA temp_store = MEMORY;";
// FULL: a commit is on the disk when it returns. The log keeps its size, so that a commit writes
// into room it has.
constexpr const char* kWriterPragmas =
    "PRAGMA synchronous = FULL; PRAGMA cache_size = -4000; PRAGMA journal_size_limit = 67108864;";

class SqliteStore final : public Store {
 public:
  SqliteStore(const std::string& path, bool read_only, const SqliteOptions& options)
      : Store({.runs = &runs_,
               .points = &points_,
               .readings = &readings_,
               .models = &models_,
               .events = &events_,
               .remarks = &remarks_,
               .diagnoses = &diagnoses_,
               .extensions = &extensions_,
               .improvements = &improvements_,
               .records = &records_,
               .alarms = &alarms_,
               .outbox = &outbox_,
               .series = &series_,
               .trajectories = &trajectories_,
               .stops = &stops_,
               .clocks = &clocks_,
               .closures = &closures_,
               .rests = &rests_,
               .configurations = &configurations_,
               .audit = &audit_,
               .queue = &queue_,
               .metadata = &metadata_,
               .plans = &plans_,
               .indentations = &indentations_,
               .upkeep = &upkeep_}),
        session_(path,
                 read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                 options.vfs, read_only),
        options_(options),
        runs_(session_),
        points_(session_),
        readings_(session_),
        models_(session_),
        events_(session_),
        remarks_(session_),
        diagnoses_(session_),
        extensions_(session_),
        improvements_(session_),
        records_(session_),
        alarms_(session_),
        outbox_(session_),
        series_(session_),
        trajectories_(session_),
        stops_(session_),
        clocks_(session_),
        closures_(session_),
        rests_(session_),
        upkeep_(session_, [this] { set_up_connection(); }),
        configurations_(session_),
        audit_(session_, protected_),
        queue_(session_),
        metadata_(session_),
        plans_(session_),
        indentations_(session_) {
    set_up_connection();
  }

  Result<void> idle() override {
    DRIFTWISE_RETURN_IF_ERROR(series_.keep_up());
    return answered([this] {
      const bool due = SteadyClock::now() - checkpointed_ >=
                       std::chrono::duration<double>(options_.checkpoint_every_s);
      if (log_pages_ >= options_.checkpoint_pages || (due && log_pages_ > 0)) checkpoint();
    });
  }

 private:
  using SteadyClock = std::chrono::steady_clock;

  void set_up_connection() {
    Database& db = session_.db;
    sqlite3_busy_timeout(db.handle(), options_.busy_timeout_ms);
    db.execute(kCommonPragmas);
    if (session_.read_only) {
      db.execute("PRAGMA query_only = ON");
      require_present_schema(db);
      return;
    }
    refuse_foreign_or_newer(db);
    db.execute("PRAGMA journal_mode = WAL");
    db.execute(kWriterPragmas);
    // The log is emptied in idle(), between points, and not by the commit that happens to fill it.
    sqlite3_wal_hook(db.handle(), &SqliteStore::committed, this);
    keep_old_version(db);
    const auto before = db.pragma("user_version");
    migrate(db);
    constexpr int kPassages = 15;  // the last version that changed what the view says
    if (before != 0 && before < kPassages) rebuild_point_wide(db);
    session_.at_commit = nullptr;
    chain_.reset();  // it refers to what is made anew
    chain_.emplace(db, protected_.emplace(db));
    chain_->begin();
    session_.at_commit = &*chain_;
    session_.files.begin(db.path(), db.pragma("page_size"));
    checkpointed_ = SteadyClock::now();
  }

  static int committed(void* self, sqlite3*, const char*, int log_pages) {
    auto& store = *static_cast<SqliteStore*>(self);
    store.log_pages_ = log_pages;
    store.session_.files.logged(log_pages);
    // The commit is durable already: a checkpoint that fails here is repeated later and must not
    // fail it.
    if (log_pages >= store.options_.checkpoint_pages * kForcedCheckpointFactor)
      (void)store.try_checkpoint();
    return SQLITE_OK;
  }

  // PASSIVE: waits for no reader; what a reader still needs stays in the log until the next time.
  int try_checkpoint() {
    const int code = sqlite3_wal_checkpoint_v2(session_.db.handle(), nullptr,
                                               SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
    session_.files.wrote();
    if (code == SQLITE_OK) {
      log_pages_ = 0;
      checkpointed_ = SteadyClock::now();
    }
    return code;
  }
  void checkpoint() {
    const int code = try_checkpoint();
    if (code != SQLITE_OK && code != SQLITE_BUSY)
      session_.db.fail_now("moving the log into the database");
  }

  Session session_;
  SqliteOptions options_;
  SteadyClock::time_point checkpointed_;
  int log_pages_ = 0;
  SqliteRunStore runs_;
  SqlitePointStore points_;
  SqliteReadingStore readings_;
  SqliteModelStore models_;
  SqliteEventStore events_;
  SqliteRemarkStore remarks_;
  SqliteDiagnosisStore diagnoses_;
  SqliteExtensionStore extensions_;
  SqliteImprovementStore improvements_;
  SqliteRecordStore records_;
  SqliteAlarmStore alarms_;
  SqliteOutboxStore outbox_;
  SqliteSeriesStore series_;
  SqliteTrajectoryStore trajectories_;
  SqliteStopStore stops_;
  SqliteClockStore clocks_;
  SqliteClosureStore closures_;
  SqliteRestStore rests_;
  SqliteUpkeepStore upkeep_;
  SqliteConfigurationStore configurations_;
  std::optional<ProtectedTables> protected_;
  std::optional<ChainRecorder> chain_;
  SqliteAuditStore audit_;
  SqliteQueueStore queue_;
  SqliteMetadataStore metadata_;
  SqlitePlanStore plans_;
  SqliteIndentationStore indentations_;
};

}  // namespace

Result<std::unique_ptr<Store>> open_sqlite_store(const std::string& path, bool read_only) {
  return open_sqlite_store(path, read_only, SqliteOptions{});
}

Result<std::unique_ptr<Store>> open_sqlite_store(const std::string& path, bool read_only,
                                                 const SqliteOptions& options) {
  return answered([&]() -> std::unique_ptr<Store> {
    const bool is_file = options.vfs.empty() && path != ":memory:";
    if (!read_only && is_file) refuse_unfinished_restore(path);
    auto store = std::make_unique<SqliteStore>(path, read_only, options);
    if (!read_only && is_file) remove_second_names(path);
    return store;
  });
}

}  // namespace driftwise::storage
