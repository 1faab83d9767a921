#pragma once
// Copies of a record: verified before they have their name, and put back without overwriting.

#include <functional>
#include <optional>
#include <string>

#include "server/core/records/copy_records.h"
#include "server/core/result.h"
#include "storage/sqlite/database.h"

namespace driftwise::storage {

// One view of an open record, into a new file: SQLite's backup, then integrity_check, the number of
// rows of every table, and the head of the chain. Until all hold, the file is called <path>.part.
// Who may read the record may read the copy, and nobody else.
// The record is written to meanwhile; its log grows as long as this takes. give_way: asked every
// 8 MB; true ends the copy. Throws StorageFailure: already_exists FILE_EXISTS, cancelled GAVE_WAY,
// data_loss DATABASE_DAMAGED, those of the disk.
RecordCopy copy_record(Database& record, const std::string& path,
                       const std::function<bool()>& give_way);

// The same for a record whose file was taken away. Pages that are damaged are kept as they are:
// data_loss DATABASE_DAMAGED, and the copy stands.
void rescue_record(Database& record, const std::string& path);

// A record of an older version is copied beside itself before its first change, as
// <database>.version-6: its path; empty: nothing is to be changed. A copy of that version is
// replaced. Errors: those of the disk; the record is as it was then.
std::string keep_old_version(Database& db);

struct Restore {
  std::string copy;      // what is put back
  std::string database;  // where to
  // The name for what is at `database` now. Empty: there must be nothing.
  std::string present_kept_as;
  std::optional<ChainHead> kept;  // a head that was kept elsewhere
};
// Checks the copy (pages, chain, the kept head), then puts it at the path, whole or not at all.
// Errors: failed_precondition SCHEMA_NEWER, NOT_DRIFTWISE, DATABASE_IN_USE (a daemon has it open);
// already_exists FILE_EXISTS; data_loss DATABASE_DAMAGED, RECORD_CHANGED (its chain does not hold).
Result<RecordCopy> restore_record(const Restore& restore);

}  // namespace driftwise::storage
