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

// Which record a file holds: copies have that of their record. Empty: it cannot be told, as of one
// that an early version left or whose pages are damaged.
std::string identity_of_record(const std::string& path);

struct Restore {
  std::string copy;      // what is put back
  std::string database;  // where to
  // The name for what is at `database` now. Empty: there must be nothing.
  std::string present_kept_as;
  std::optional<ChainHead> kept;  // a head that was kept elsewhere
  bool may_be_another = false;    // a copy of another record than the present one
  // Called when all is checked, right before the first name changes. What it throws ends the
  // restore with everything as it was.
  std::function<void()> before_names_change = {};
};
// Checks the copy (pages, chain, the kept head), then puts it at the path, whole or not at all. At
// no instant is there another record at the path than the present one with its log, or the copy; on
// file systems without hard links there may be none, which refuse_unfinished_restore() tells.
// Errors: failed_precondition SCHEMA_NEWER, NOT_DRIFTWISE, DATABASE_IN_USE (a daemon has it open,
// or a program reads it), OTHER_RECORD; already_exists FILE_EXISTS; data_loss DATABASE_DAMAGED,
// RECORD_CHANGED (its chain does not hold).
Result<RecordCopy> restore_record(const Restore& restore);

// For a daemon that is about to make a record: throws failed_precondition RESTORE_UNFINISHED where
// there is none at the path and what a restore left stands beside it.
void refuse_unfinished_restore(const std::string& database);
// For a daemon that has its record open, and with it the lock: the second name goes that a restore
// gave the record before it was interrupted.
void remove_second_names(const std::string& database);

}  // namespace driftwise::storage
