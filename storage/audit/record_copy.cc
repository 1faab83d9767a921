#include "storage/audit/record_copy.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "server/core/reasons.h"
#include "server/digest/sha256.h"
#include "storage/chain/chain_check.h"
#include "storage/schema/schema.h"
#include "storage/sqlite/database_lock.h"
#include "storage/sqlite/failure.h"
#include "storage/sqlite/file_owner.h"
#include "storage/sqlite/gives_way.h"
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

[[noreturn]] void throw_gave_way() {
  throw_failure(ErrorCode::cancelled, reasons::kGaveWay, "the copy gave way: ask again");
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
  if (gave_way && (code == SQLITE_OK || is_held(code))) throw_gave_way();
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

// Counting and checking take as long as copying: each statement of both gives way.
template <class Work>
void giving_way(Database& record, Database& copy, const std::function<bool()>& give_way,
                Work work) {
  const GivesWay of_record(record, give_way), of_copy(copy, give_way);
  try {
    work();
  } catch (const StorageFailure&) {
    if (of_record.gave_way() || of_copy.gave_way()) throw_gave_way();
    throw;
  }
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
    giving_way(record, to, give_way, [&] {
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
    });
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

// SQLite deletes the log beside a file without a page when it opens that file: one that is no
// database any more is not opened.
bool is_database(const std::string& path) {
  constexpr std::string_view kBegin{"SQLite format 3", 16};
  std::string found(kBegin.size(), ' ');
  std::ifstream file(path, std::ios::binary);
  file.read(found.data(), static_cast<std::streamsize>(found.size()));
  return file.good() && found == kBegin;
}

std::string identity_in(Database& db) {
  constexpr int kIdentityVersion = 4;
  std::string identity;
  if (db.pragma("user_version") >= kIdentityVersion)
    db.for_each_row("SELECT id FROM database_identity",
                    [&](const std::string& id) { identity = id; });
  return identity;
}

void refuse_other_record(Database& copy, const Restore& restore) {
  if (restore.may_be_another) return;
  const auto found = identity_in(copy), present = identity_of_record(restore.database);
  if (found.empty() || present.empty() || found == present) return;
  throw_failure(ErrorCode::failed_precondition, reasons::kOtherRecord,
                restore.copy + " is a copy of record " + found + ", and " + restore.database +
                    " is record " + present +
                    ": nothing was put back; look whether it is this cell's copy");
}

// What the log of a record holds is in its file after this, and the log is empty. False: it cannot
// be, as where the pages are damaged; then the file and the log belong together.
bool bring_log_into(const std::string& path) {
  if (!is_database(path)) return false;
  int code = SQLITE_OK;
  try {
    Database record(path, SQLITE_OPEN_READWRITE, "");
    if (record.pragma("application_id") != kApplicationId) return false;
    code = sqlite3_wal_checkpoint_v2(record.handle(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr,
                                     nullptr);
  } catch (const StorageFailure&) {
    return false;
  }
  if (is_held(code))
    throw_failure(ErrorCode::failed_precondition, reasons::kDatabaseInUse,
                  "a program reads the record " + path +
                      " (a sqlite3 shell, an export): end it and restore again; nothing was put "
                      "back");
  return code == SQLITE_OK;
}

std::string folder_of(const std::string& path) { return fs::absolute(path).parent_path().string(); }

std::vector<fs::path> left_by_restore(const std::string& database) {
  const std::string name = fs::path(database).filename().string();
  std::vector<fs::path> left;
  std::error_code failed;
  for (fs::directory_iterator entry(folder_of(database), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string other = entry->path().filename().string();
    if (other == name + Part::kSuffix || other.starts_with(name + ".before-"))
      left.push_back(entry->path());
  }
  return left;
}

[[noreturn]] void throw_not_named(const std::string& from, const std::string& to,
                                  const std::error_code& why) {
  throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                "the present record's file " + from + " cannot be named " + to + ": " +
                    why.message() + "; nothing was put back");
}

// The present record gets the other name. One whose log is in it keeps its own as well, until the
// copy takes that in one step. Else the file goes first and its log after it: a log that is left
// behind belongs to nothing else, where a file without its log would be an older record. Who could
// read it before can read the copy, and nobody else.
void set_present_aside(const Restore& restore) {
  const std::string& present = restore.database;
  const std::string& kept_as = restore.present_kept_as;
  std::error_code failed;
  const auto rights = fs::status(present, failed).permissions();
  if (!failed) fs::permissions(present + Part::kSuffix, rights, failed);
  if (failed)
    throw_failure(ErrorCode::not_found, reasons::kCannotOpen,
                  "the copy cannot have the rights of " + present + ": " + failed.message() +
                      "; nothing was put back");
  bool has_both_names = bring_log_into(present);
  if (has_both_names) {
    fs::create_hard_link(present, kept_as, failed);
    has_both_names = !failed;
  }
  if (!has_both_names) {
    fs::rename(present, kept_as, failed);
    if (failed) throw_not_named(present, kept_as, failed);
  }
  sync(folder_of(present));
  for (const char* part : {"-wal", "-shm"}) {
    if (!is_present(present + part)) continue;
    fs::rename(present + part, kept_as + part, failed);
    if (!failed) continue;
    std::error_code ignored;
    has_both_names ? static_cast<void>(fs::remove(kept_as, ignored))
                   : fs::rename(kept_as, present, ignored);
    throw_not_named(present + part, kept_as + part, failed);
  }
  sync(folder_of(present));
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
      refuse_other_record(copy, restore);
    } else {
      refuse_present(restore.database);
    }
    return copy_verified(copy, restore.database, {}, [&] {
      if (restore.before_names_change) restore.before_names_change();
      if (replaces) set_present_aside(restore);
    });
  });
}

void remove_second_names(const std::string& database) {
  std::error_code failed;
  for (const auto& path : left_by_restore(database))
    if (fs::equivalent(path, database, failed)) fs::remove(path, failed);
}

std::string identity_of_record(const std::string& path) {
  if (!is_database(path)) return {};
  try {
    Database record(path, SQLITE_OPEN_READONLY, "");
    return identity_in(record);
  } catch (const StorageFailure&) {
    return {};
  }
}

void refuse_unfinished_restore(const std::string& database) {
  if (is_present(database)) return;
  const std::string name = fs::path(database).filename().string();
  std::string left;
  for (const auto& path : left_by_restore(database))
    left += (left.empty() ? "" : ", ") + path.string();
  if (left.empty()) return;
  throw_failure(ErrorCode::failed_precondition, reasons::kRestoreUnfinished,
                "there is no record " + database + ", and beside it stands what a restore left: " +
                    left + ". Name the newest " + name + ".before-... " + database +
                    " again, or run `driftwise restore` with the copy; for a new record move these "
                    "files to another folder");
}

}  // namespace driftwise::storage
