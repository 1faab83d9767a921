#include "storage/audit/record_copy.h"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <optional>

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
constexpr int kPauseMs = 20;  // while another connection writes the copied pages

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

void copy_pages(Database& from, Database& to, const std::function<bool()>& give_way) {
  sqlite3_backup* backup = sqlite3_backup_init(to.handle(), "main", from.handle(), "main");
  if (backup == nullptr) to.fail_now("copying the record");
  int code = SQLITE_OK;
  bool gave_way = false;
  do {
    code = sqlite3_backup_step(backup, kPagesPerStep);
    if (code == SQLITE_BUSY || code == SQLITE_LOCKED) sqlite3_sleep(kPauseMs);
    gave_way = give_way && give_way();
  } while (!gave_way && (code == SQLITE_OK || code == SQLITE_BUSY || code == SQLITE_LOCKED));
  const int finished = sqlite3_backup_finish(backup);
  if (gave_way && code != SQLITE_DONE)
    throw_failure(ErrorCode::cancelled, reasons::kGaveWay, "the copy gave way: ask again");
  if (finished != SQLITE_OK) to.fail_now("copying the record");
}

void sync(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

// A copy that is not finished is taken away again.
class Part {
 public:
  static constexpr const char* kSuffix = ".part";
  explicit Part(const std::string& path) : path_(path), part_(path + kSuffix) { remove(); }
  ~Part() { remove(); }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  const std::string& path() const { return part_; }
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
  Part part(path);
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
  give_to_owner_of_folder(part.path());
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
