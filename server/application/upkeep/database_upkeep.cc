#include "server/application/upkeep/database_upkeep.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "server/application/plumbing/task_group.h"
#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr double kLogAlarmStands_s = 3600;
constexpr double kPause_s = 1;     // between two tables
constexpr double kWaitIdle_s = 5;  // until the next look whether the cell is idle

}  // namespace

DatabaseUpkeep::DatabaseUpkeep(asio::any_io_executor executor, Clock& clock, std::string path,
                               StoreWriter& writer, std::vector<StoreReader*> readers,
                               StoreReader* checker, EventLog& events, TaskGroup& tasks,
                               std::function<bool()> busy, BackupRules backups,
                               ThinningRules thinning)
    : executor_(executor),
      clock_(clock),
      path_(std::move(path)),
      writer_(writer),
      readers_(std::move(readers)),
      checker_(checker),
      events_(events),
      tasks_(tasks),
      busy_(std::move(busy)),
      backups_(clock, path_, std::move(backups), checker ? *checker : *readers_.front(), events,
               [this] { return gives_way_.load(); }),
      thinning_(std::move(thinning)),
      ended_(executor) {}

void DatabaseUpkeep::start() {
  tasks_.spawn(watch());
  tasks_.spawn(keep_measured());
  tasks_.spawn(keep_backups());
  if (thinning_.after_days > 0) tasks_.spawn(keep_thin());
  if (!checker_) return;
  tasks_.spawn(check());
}

void DatabaseUpkeep::shut_down() {
  ending_ = true;
  gives_way_ = true;
  ended_.raise();
}

std::int64_t DatabaseUpkeep::log_bytes() const {
  std::error_code none;
  const auto bytes = std::filesystem::file_size(path_ + "-wal", none);
  return none ? 0 : static_cast<std::int64_t>(bytes);
}

// "cell.sqlite.kept-20261122T093000Z", beside the path that the cell file names.
std::string DatabaseUpkeep::copy_path() const {
  std::string instant = to_iso8601(clock_.utc(clock_.now().utc)).substr(0, 19);
  std::erase_if(instant, [](char c) { return c == '-' || c == ':'; });
  return path_ + ".kept-" + instant + "Z";
}

Awaitable<void> DatabaseUpkeep::watch() {
  while (!ending_) {
    co_await look();
    const double seconds = std::max(kLook_s, 0.5 * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(seconds), ended_);
  }
}

Awaitable<void> DatabaseUpkeep::keep_backups() {
  constexpr double kLookAtSchedule_s = 60;
  co_await backups_.look_at_folder();
  measure();  // the forecast begins when the folder is known
  co_await backups_.remove_unfinished();
  while (!ending_) {
    co_await backups_.look_at_folder();
    co_await backups_.make_if_due();
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(kLookAtSchedule_s), ended_);
  }
}

// Its own task: a copy takes as long as the disk needs, and that is when the disk fills.
Awaitable<void> DatabaseUpkeep::keep_measured() {
  while (!ending_) {
    measure();
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(kMeasure_s), ended_);
  }
}

void DatabaseUpkeep::measure() {
  std::error_code none;
  const auto bytes = std::filesystem::file_size(path_, none);
  if (none) return;
  const auto space = std::filesystem::space(std::filesystem::path(path_).parent_path(), none);
  if (none) return;
  const auto now = clock_.now().utc;
  disk_free_gb_ = static_cast<double>(space.available) / 1e9;
  disk_looked_at_ = now;
  if (const auto on_disk = backups_.on_disk_of_database())
    forecast_.take({now, static_cast<std::int64_t>(bytes) + log_bytes(),
                    static_cast<std::int64_t>(space.available), on_disk->bytes},
                   on_disk->to_come);
}

std::optional<double> DatabaseUpkeep::disk_free_gb() const {
  if (seconds_from(clock_.now().utc - disk_looked_at_) > 2 * kMeasure_s) return std::nullopt;
  return disk_free_gb_;
}

Awaitable<Result<RecordCopy>> DatabaseUpkeep::back_up(Caller caller) {
  co_return co_await backups_.make(&caller);
}

Awaitable<Result<ThinningStep>> DatabaseUpkeep::thin(ThinningOrder order, Caller caller) {
  constexpr double kNewest_s = 3600;
  if (seconds_from(clock_.now().utc - order.before) < kNewest_s)
    co_return fail(ErrorCode::invalid_argument, reasons::kBadRange,
                   "before: found " + to_iso8601(clock_.utc(order.before)) +
                       ", expected an instant that is at least an hour ago: newer readings stay as "
                       "they are");
  order.by = {caller.name, caller.proof.empty() ? "stated" : caller.proof, caller.peer};
  const std::string what = fmt::format("readings before {}", to_iso8601(clock_.utc(order.before)));
  const std::string how =
      fmt::format("{} every {:g} s", order.reducer, static_cast<double>(order.every_ns) * 1e-9);
  ThinningStep done;
  auto thinning = thin_in_steps(std::move(order), done);
  const auto ended = co_await std::move(thinning);
  // What was thinned before a failure stays thinned.
  if (ended || done.readings > 0)
    events_.record(caller, "readings.thinned",
                   fmt::format("{} readings of the environment became {} rows: {}, {}",
                               done.readings, done.intervals, what, how),
                   {},
                   {what, fmt::format("{} readings", done.readings), how,
                    ended ? "" : "ended before its time: " + ended.error().message});
  DRIFTWISE_CO_RETURN_IF_ERROR(ended);
  co_return done;
}

Awaitable<Result<void>> DatabaseUpkeep::thin_in_steps(ThinningOrder order, ThinningStep& done) {
  if (thinning_under_way_)
    co_return fail(ErrorCode::failed_precondition, reasons::kThinningUnderWay,
                   "readings are being thinned already: ask again when that is done");
  thinning_under_way_ = true;
  // Plots have every reading before it goes.
  Result<bool> waits = true;
  while (waits && *waits && !ending_)
    waits = co_await writer_.call([](Store& store) { return store.series().summarise(); });
  Result<ThinningStep> step = ThinningStep{.looked_id = order.after_id, .more = true};
  while (step && step->more && !ending_) {
    order.at = clock_.now();
    order.after_id = step->looked_id;
    step = co_await writer_.call(
        [](Store& store, const ThinningOrder& wanted) { return store.audit().thin(wanted); },
        order);
    if (!step) break;
    done.looked_id = step->looked_id;
    done.readings += step->readings;
    done.intervals += step->intervals;
    // Points and readings of the cell come between two steps.
    co_await sleep_unless(clock_, clock_.now().utc + nanoseconds_from_s(0.02), ended_);
  }
  thinning_under_way_ = false;
  DRIFTWISE_CO_RETURN_IF_ERROR(step);
  if (step->more)
    co_return fail(ErrorCode::unavailable, reasons::kShuttingDown,
                   "the daemon ends: ask again after its start; what was thinned stays thinned");
  co_return Result<void>{};
}

Awaitable<void> DatabaseUpkeep::keep_thin() {
  // What this daemon has looked at by the same rule: it stays as it is.
  std::int64_t looked_id = 0;
  while (!ending_) {
    const auto now = clock_.now().utc;
    ThinningOrder order;
    order.before = now - nanoseconds_from_s(thinning_.after_days * 86'400);
    order.every_ns = nanoseconds_from_s(thinning_.every_s).count();
    order.reducer = thinning_.reducer;
    order.by = {"daemon", "cell file", ""};
    order.after_id = looked_id;
    ThinningStep done;
    done.looked_id = looked_id;
    auto thinning = thin_in_steps(order, done);
    const auto ended = co_await std::move(thinning);
    looked_id = done.looked_id;
    if (!ended) spdlog::warn("[thinning]: {}", ended.error().message);
    if (done.readings > 0)
      events_.record_own(
          "readings.thinned",
          fmt::format("{} readings of the environment older than {:g} days became {} rows by "
                      "[thinning] of the cell file",
                      done.readings, thinning_.after_days, done.intervals));
    co_await sleep_unless(clock_, now + nanoseconds_from_s(kThinEvery_s), ended_);
  }
}

std::vector<StoreReader*> DatabaseUpkeep::all_readers() const {
  auto all = readers_;
  if (checker_) all.push_back(checker_);
  return all;
}

bool DatabaseUpkeep::any_reader_waits() const {
  return std::ranges::any_of(all_readers(), &StoreReader::suspended);
}

Awaitable<void> DatabaseUpkeep::look() {
  if (!reopened_) co_await open_again();
  if (!reopened_) co_return;  // closed: how its files are says nothing
  if (any_reader_waits()) co_await resume_readers();
  const auto state = co_await writer_.call([](Store& store) -> Result<DatabaseFiles> {
    return store.upkeep() ? store.upkeep()->files() : DatabaseFiles::good;
  });
  const auto before = std::exchange(files_, *state);
  if (files_ == DatabaseFiles::good || files_ == DatabaseFiles::log_gone) {
    if (!files_message_.empty())
      events_.record_own("database.back", "database " + path_ + " is at its path again");
    files_message_.clear();
    if (files_ == DatabaseFiles::log_gone) co_await replace_log();
    co_return;
  }
  if (files_ != before) {
    files_message_.clear();
    kept_ = false;
    keep_again_ = {};
  }
  if (!kept_ && keep_again_ <= clock_.now().utc) co_await keep_copy();
}

// Everything in the log goes into the database; then every connection is closed and opened again,
// so that the log at the path is the one in use. Until the first is done nobody lets go of the open
// log, and the next look tries again: what was told is nowhere else.
Awaitable<void> DatabaseUpkeep::replace_log() {
  gives_way_ = true;
  for (auto* reader : all_readers()) co_await reader->hold();
  secured_ =
      co_await writer_.call([](Store& store) -> Result<void> { return store.upkeep()->secure(); });
  if (secured_) {
    for (auto* reader : all_readers()) co_await reader->suspend();
    co_await open_again();
  } else {
    tell_of_log(
        "what it held could not all be moved into the database: " + secured_.error().message +
        ". It is only in the log that the daemon holds open: do not end the daemon. Nothing more "
        "is stored, the run waits, and it is tried again every few seconds");
    co_await resume_readers();
  }
  gives_way_ = ending_;
}

void DatabaseUpkeep::tell_of_log(const std::string& outcome) {
  log_lost_ = clock_.now().utc;
  auto message = fmt::format(
      "the log of database {} ({}-wal) was deleted or cut off by another program: {}; look what "
      "deletes files there",
      path_, path_, outcome);
  const bool told = message == log_message_;
  log_message_ = std::move(message);
  if (told && (!secured_ || !reopened_)) return;  // nothing has changed since the last try
  spdlog::error("{}", log_message_);
  events_.record_own("database.log_gone", log_message_);
}

Awaitable<void> DatabaseUpkeep::open_again() {
  reopened_ =
      co_await writer_.call([](Store& store) -> Result<void> { return store.upkeep()->reopen(); });
  tell_of_log(!reopened_ ? "all of it is in the database, and a new one could not be opened: " +
                               reopened_.error().message
                         : "all of it is in the database, and a new one is in use");
  if (reopened_) co_await resume_readers();
}

Awaitable<void> DatabaseUpkeep::resume_readers() {
  reader_message_.clear();
  for (auto* reader : all_readers()) {
    const auto resumed = co_await reader->resume();
    if (!resumed)
      reader_message_ = fmt::format(
          "queries wait, for database {} cannot be opened for reading: {}; it is tried again every "
          "few seconds",
          path_, resumed.error().message);
  }
}

void DatabaseUpkeep::list_troubles() {
  health_.troubles.clear();
  if (!first_trouble_.empty()) health_.troubles.push_back(first_trouble_);
  for (const auto& one : checks_.tables)
    if (!one.trouble.empty())
      health_.troubles.push_back(fmt::format(
          "table {} of database {} is damaged: {}; keep a copy, then restore a backup, or save "
          "what can be read with: sqlite3 {} .recover",
          one.table, path_, one.trouble, path_));
}

Awaitable<void> DatabaseUpkeep::keep_copy() {
  const std::string target = copy_path();
  const auto copied = co_await writer_.call(
      [](Store& store, const std::string& path) { return store.upkeep()->copy_to(path); }, target);
  // A copy with damaged pages stands all the same: another one would hold no more.
  kept_ = copied || copied.error().reason == reasons::kDatabaseDamaged;
  keep_again_ = clock_.now().utc + nanoseconds_from_s(kKeepAgain_s);
  const char* what = files_ == DatabaseFiles::moved      ? "is no longer at its path"
                     : files_ == DatabaseFiles::replaced ? "has been replaced by another file"
                                                         : "has been written by another program";
  const char* then = files_ == DatabaseFiles::overwritten
                         ? "stop the daemon, put the copy or a backup at the path, start it again"
                         : "put the file back and the cell continues, or stop the daemon, put the "
                           "copy at the path and start it again";
  auto message = fmt::format(
      "database {} {}: no point is stored and the run waits. {}. {}", path_, what,
      copied  ? fmt::format("The record that is held open was copied to {}", target)
      : kept_ ? fmt::format("The record that is held open could not be copied whole: {}",
                            copied.error().message)
              : fmt::format("The record that is held open could not be copied, which is "
                            "tried again every minute, and is whole only while the "
                            "daemon runs: {}",
                            copied.error().message),
      then);
  const bool tell = kept_ || files_message_.empty();
  files_message_ = std::move(message);
  if (!tell) co_return;
  spdlog::error("{}", files_message_);
  events_.record_own("database.files", files_message_);
}

std::vector<AlarmCondition> DatabaseUpkeep::conditions() const {
  std::vector<AlarmCondition> out;
  if (!files_message_.empty())
    out.push_back({AlarmLevel::failed, "database.files", "database", files_message_});
  if (!reader_message_.empty())
    out.push_back({AlarmLevel::failed, "database.log_gone", "database readers", reader_message_});
  const bool lately =
      log_lost_.utc_ns != 0 && seconds_from(clock_.now().utc - log_lost_) < kLogAlarmStands_s;
  if (lately) out.push_back({AlarmLevel::failed, "database.log_gone", "database", log_message_});
  if (auto warning = forecast_.warning(path_); !warning.empty())
    out.push_back({AlarmLevel::warning, "disk.forecast", "database", std::move(warning)});
  for (auto& condition : backups_.conditions()) out.push_back(std::move(condition));
  for (const auto& trouble : health_.troubles)
    out.push_back({AlarmLevel::failed, "database.damaged", "database", trouble});
  return out;
}

// First check, right after the start: the parts whose reading costs the same at any size.
Awaitable<void> DatabaseUpkeep::first_look() {
  const auto looked = co_await checker_->call([](Store& store) -> Result<std::string> {
    return store.upkeep() ? store.upkeep()->check("", {}) : std::string();
  });
  if (!looked || !looked->empty())
    first_trouble_ = fmt::format(
        "the newest records of database {} cannot be read whole: {}; keep a copy, then restore a "
        "backup",
        path_, looked ? *looked : looked.error().message);
  list_troubles();
  const auto known = co_await checker_->call([](Store& store) -> Result<DatabaseChecks> {
    return store.upkeep() ? store.upkeep()->checks() : DatabaseChecks{};
  });
  if (!known) co_return;
  checks_ = *known;
  health_.last_clean = checks_.last_clean;
  list_troubles();
}

Awaitable<void> DatabaseUpkeep::check() {
  co_await first_look();
  auto next = clock_.now().utc + nanoseconds_from_s(kFirstCheck_s);
  auto overdue = clock_.now().utc + nanoseconds_from_s(kPassEvery_s);
  while (!ending_) {
    co_await sleep_unless(clock_, next, ended_);
    const auto now = clock_.now().utc;
    if (ending_ || now < next) continue;
    next = now + nanoseconds_from_s(kWaitIdle_s);
    const bool wrong_moment = busy_() && now < overdue;
    if (wrong_moment || files_ != DatabaseFiles::good || log_bytes() > kMostLogBytes) continue;
    if (co_await check_next_table()) {
      next = clock_.now().utc + nanoseconds_from_s(kPause_s);
      continue;
    }
    next = clock_.now().utc + nanoseconds_from_s(kPassEvery_s);
    overdue = next + nanoseconds_from_s(kPassEvery_s);
  }
}

Awaitable<Result<ChainReport>> DatabaseUpkeep::verify(std::optional<ChainHead> kept) {
  StoreReader* const reader = checker_ != nullptr ? checker_ : readers_.front();
  co_return co_await reader->call(
      [this](Store& store, const std::optional<ChainHead>& head) {
        return store.audit().verify(head, [this] { return gives_way_.load(); });
      },
      kept);
}

Awaitable<bool> DatabaseUpkeep::check_next_table() {
  const auto tables = co_await checker_->call([](Store& store) -> Result<std::vector<std::string>> {
    return store.upkeep() ? store.upkeep()->tables() : std::vector<std::string>();
  });
  if (!tables || tables->empty()) co_return false;
  const auto last_of = [this](const std::string& table) {
    const auto known = std::ranges::find(checks_.tables, table, &TableCheck::table);
    return known == checks_.tables.end() ? CellTime{0} : known->checked;
  };
  std::vector<std::string> left;
  const auto list = [&] {
    left.clear();
    for (const auto& table : *tables)
      if (last_of(table) < checks_.begun) left.push_back(table);
  };
  list();
  const auto now = clock_.now().utc;
  // A new pass, or the first, or one of before the clock was set back.
  if (left.empty() || checks_.begun.utc_ns == 0 || now < checks_.begun) {
    checks_.begun = now;
    for (auto& one : checks_.tables)
      if (one.checked >= now) one.checked = CellTime{0};  // by that other clock
    list();
  }
  health_.tables = static_cast<std::int64_t>(tables->size());
  health_.tables_checked = static_cast<std::int64_t>(tables->size() - left.size());
  const std::string table = left.front();
  const auto found = co_await checker_->call(
      [this](Store& store, const std::string& name) {
        return store.upkeep()->check(
            name, [this] { return gives_way_.load() || log_bytes() > kMostLogBytes; });
      },
      table);
  if (!found) co_return true;  // gave way: again later
  TableCheck done{table, clock_.now().utc, *found};
  std::erase_if(checks_.tables, [&](const TableCheck& one) { return one.table == table; });
  checks_.tables.push_back(done);
  const bool all = left.size() == 1;
  const bool clean = all && std::ranges::all_of(checks_.tables, [](const TableCheck& one) {
                       return one.trouble.empty();
                     });
  static_cast<void>(co_await writer_.call(  // told again by the next pass
      [begun = checks_.begun, clean](Store& store, const TableCheck& check) {
        return store.upkeep() ? store.upkeep()->keep_check(check, begun, clean) : Result<void>{};
      },
      done));
  health_.tables_checked = health_.tables - static_cast<std::int64_t>(left.size()) + 1;
  if (clean) health_.last_clean = done.checked;
  list_troubles();
  if (!done.trouble.empty()) events_.record_own("database.damaged", health_.troubles.back());
  co_return !all;
}

}  // namespace driftwise::application
