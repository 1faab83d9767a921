#include "storage/audit/record_copy.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>

#include "server/core/reasons.h"
#include "server/digest/sha256.h"
#include "storage/chain/chain_check.h"
#include "storage/schema/schema.h"
#include "storage/sqlite/database_lock.h"
#include "storage/sqlite/failure.h"
#include "storage/sqlite/file_owner.h"
#include "storage/sqlite/present_file.h"

namespace driftwise::storage {
namespace {

namespace fs = std::filesystem;
constexpr int kPagesPerStep = 2048;
constexpr int kPauseMs = 20;      // while another connection has the copied pages
constexpr int kMostPauses = 500;  // without a page in between: 10 s

void refuse_present(const std::string& path) {
  for (const char* part : {"", "-wal"})
    if (is_present(path + part))
      throw_failure(ErrorCode::already_exists, reasons::kFileExists,
                    "there is a file " + path + part + " already: nothing was overwritten");
}

std::map<std::string, std::int64_t> row_counts(Database& db) {
  std::map<std::string, std::int64_t> counts;
  std::vector<std::string> tables;
  db.for_each_row("SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name",
                  [&](const std::string& name) { tables.push_back(name); });
  for (const auto& table : tables)
    db.for_each_row("SELECT count(*) FROM \"" + table + "\"",
                    [&](const std::string& count) { counts[table] = std::stoll(count); });
  return counts;
}

ChainHead head_of(Database& db) {
  if (db.pragma("user_version") < kChainVersion) return {};
  const ChainEntry newest = newest_entry(db);
  if (newest.number == 0) return {};
  return {newest.number, digest::hex_from(newest.head)};
}

void require_sound(Database& db) {
  std::string trouble;
  db.for_each_row("PRAGMA integrity_check(1)", [&](const std::string& line) {
    if (line != "ok") trouble = line;
  });
  if (!trouble.empty())
    throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                  db.path() + " is damaged: " + trouble);
}

bool is_held(int code) { return (code & 0xff) == SQLITE_BUSY || (code & 0xff) == SQLITE_LOCKED; }

void copy_pages(Database& from, Database& to, const std::function<bool()>& give_way) {
  from.require_open();
  sqlite3_backup* backup = sqlite3_backup_init(to.handle(), "main", from.handle(), "main");
  if (backup == nullptr) to.fail_now("copying the record");
  int code = SQLITE_OK, pauses = 0;
  bool gave_way = false;
  while (!gave_way && (code == SQLITE_OK || (is_held(code) && pauses < kMostPauses))) {
    code = sqlite3_backup_step(backup, kPagesPerStep);
    pauses = is_held(code) ? pauses + 1 : 0;
    if (pauses > 0) sqlite3_sleep(kPauseMs);
    gave_way = give_way && give_way();
  }
  const int finished = sqlite3_backup_finish(backup);
  if (code == SQLITE_DONE && finished == SQLITE_OK) return;
  if (gave_way && (code == SQLITE_OK || is_held(code)))
    throw_failure(ErrorCode::cancelled, reasons::kGaveWay, "the copy gave way: ask again");
  if (is_held(code))  // which finish() does not tell
    throw StorageFailure{
        error_from_sqlite(code, 0, from.path(), "copying the record", sqlite3_errstr(code))};
  to.fail_now("copying the record");
}

void sync(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

// Rights of a file; where they cannot be told, as of one that was moved away: the owner's alone.
mode_t rights_of(const std::string& path) {
  struct stat found {};
  constexpr mode_t kOfAll = 0777, kOwnerOnly = 0600;
  return ::stat(path.c_str(), &found) == 0 ? found.st_mode & kOfAll : kOwnerOnly;
}

// A copy that is not finished is taken away again. It has the rights of its record: what is in the
// one is in the other.
class Part {
 public:
  static constexpr const char* kSuffix = ".part";
  Part(const std::string& path, const std::string& record)
      : path_(path), part_(path + kSuffix), rights_(rights_of(record)) {
    remove();
    const int file = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file >= 0) ::close(file);  // otherwise the one that opens it says why
  }
  ~Part() { remove(); }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  const std::string& path() const { return part_; }
  void take_rights() const {
    give_to_owner_of_folder(part_);
    if (::chmod(part_.c_str(), rights_) == 0) return;
    throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                  "the copy " + part_ + " cannot have the rights of its record: " +
                      std::generic_category().message(errno));
  }
  // On the disk under its name, before this returns.
  void finish() {
    sync(part_);
    std::error_code failed;
    fs::rename(part_, path_, failed);
    if (failed)
      throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                    "the copy cannot be named " + path_ + ": " + failed.message());
    sync(fs::absolute(path_).parent_path().string());
  }

 private:
  void remove() const {
    std::error_code ignored;
    for (const char* log : {"", "-wal", "-shm", "-journal"}) fs::remove(part_ + log, ignored);
  }
  std::string path_, part_;
  mode_t rights_;
};

std::int64_t bytes_of(const std::string& path) {
  std::error_code failed;
  const auto bytes = fs::file_size(path, failed);
  if (failed)
    throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                  "the copy " + path + " cannot be measured: " + failed.message());
  return static_cast<std::int64_t>(bytes);
}

// make_room: right before the copy takes its name.
RecordCopy copy_verified(Database& record, const std::string& path,
                         const std::function<bool()>& give_way,
                         const std::function<void()>& make_room) {
  Part part(path, record.path());
  RecordCopy copy{path, 0, 0, {}};
  {
    Database to(part.path(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
    std::map<std::string, std::int64_t> counts;
    {
      const Transaction view(record, Transaction::Kind::read);
      counts = row_counts(record);
      copy.head = head_of(record);
      copy_pages(record, to, give_way);
    }
    to.execute("PRAGMA journal_mode = DELETE");  // one file, without a log beside it
    require_sound(to);
    if (row_counts(to) != counts || head_of(to) != copy.head)
      throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                    "the copy of " + record.path() +
                        " has other rows than the record: it was not kept, make it again");
    for (const auto& [table, count] : counts) copy.rows += count;
  }
  copy.bytes = bytes_of(part.path());
  part.take_rights();
  make_room();
  part.finish();
  return copy;
}

// The copy's chain, where its schema has one that this program knows.
void require_chain(Database& db, const std::optional<ChainHead>& kept) {
  if (db.pragma("user_version") < schema_version()) {
    if (kept)
      throw_failure(ErrorCode::failed_precondition, reasons::kSchemaOlder,
                    db.path() +
                        " has an older schema: its chain can only be held against a head by the "
                        "program that wrote it");
    return;
  }
  ProtectedTables tables(db);
  ChainCheck check(db, tables, kept);
  while (check.step()) {
  }
  if (check.report().intact()) return;
  throw_failure(ErrorCode::data_loss, reasons::kRecordChanged,
                db.path() + " was changed since it was stored: " + check.report().first.front() +
                    "; nothing was put back");
}

// The present record gets the other name. Who could read it before can read the copy, and nobody
// else.
void set_present_aside(const Restore& restore) {
  std::error_code failed;
  const auto rights = fs::status(restore.database, failed).permissions();
  if (!failed) fs::permissions(restore.database + Part::kSuffix, rights, failed);
  if (failed)
    throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                  "the copy cannot have the rights of " + restore.database + ": " +
                      failed.message() + "; nothing was put back");
  for (const char* part : {"-wal", "-shm", ""}) {
    if (!is_present(restore.database + part)) continue;
    fs::rename(restore.database + part, restore.present_kept_as + part, failed);
    if (failed)
      throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                    "the present record's file " + restore.database + part + " cannot be named " +
                        restore.present_kept_as + part + ": " + failed.message() +
                        "; nothing was put back");
  }
}

}  // namespace

RecordCopy copy_record(Database& record, const std::string& path,
                       const std::function<bool()>& give_way) {
  refuse_present(path);
  return copy_verified(record, path, give_way, [] {});
}

std::string keep_old_version(Database& db) {
  const auto version = db.pragma("user_version");
  if (version == 0 || version >= schema_version() || db.path().empty()) return {};
  const auto path = db.path() + ".version-" + std::to_string(version);
  copy_verified(db, path, {}, [] {});
  return path;
}

void rescue_record(Database& record, const std::string& path) {
  refuse_present(path);
  std::string trouble;
  try {
    copy_verified(record, path, {}, [] {});
    return;
  } catch (const StorageFailure& failure) {
    if (failure.error.reason != reasons::kDatabaseDamaged) throw;
    trouble = failure.error.message;
  }
  Part part(path, record.path());
  {
    Database to(part.path(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
    copy_pages(record, to, {});
  }
  part.take_rights();
  part.finish();
  throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                "the copy " + path + " holds what could be read, and is damaged: " + trouble);
}

Result<RecordCopy> restore_record(const Restore& restore) {
  return answered([&] {
    Database copy(restore.copy, SQLITE_OPEN_READONLY, "");
    refuse_foreign_or_newer(copy);
    require_sound(copy);
    require_chain(copy, restore.kept);
    std::optional<DatabaseLock> nobody_has_it;
    const bool replaces = !restore.present_kept_as.empty() && is_present(restore.database);
    if (replaces) {
      refuse_present(restore.present_kept_as);
      nobody_has_it.emplace(restore.database);
    } else {
      refuse_present(restore.database);
    }
    return copy_verified(copy, restore.database, {}, [&] {
      if (replaces) set_present_aside(restore);
    });
  });
}

}  // namespace driftwise::storage
