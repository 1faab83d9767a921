#pragma once
// Inside this room a failing SQLite call throws StorageFailure, so that a method reads as the SQL
// it runs and a transaction rolls back by leaving its scope. answered() turns it, and every other
// exception, into a Result at the port: nothing leaves.

#include <exception>
#include <new>
#include <string>
#include <type_traits>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/result.h"

struct sqlite3;

namespace driftwise::storage {

struct StorageFailure {
  Error error;
};

[[noreturn]] void throw_failure(ErrorCode code, std::string reason, std::string message);

// What a SQLite result code means for the daemon, naming the file and what to do:
//   full disk                         resource_exhausted  DISK_FULL
//   a disk that became read-only      resource_exhausted  READ_ONLY
//   the disk answers with an error    data_loss           DISK_ERROR
//   damaged file, or no database      data_loss           DATABASE_DAMAGED
//   another program holds the lock    failed_precondition DATABASE_LOCKED
//   written through a read-only store failed_precondition READ_ONLY
//   file or folder cannot be opened   not_found           CANNOT_OPEN
//   unique or primary key taken       already_exists      ALREADY_STORED
//   a run, datum or model is missing  not_found           NO_SUCH_RECORD
//   anything else                     internal            SQLITE_ERROR
// code: the extended result code; system_errno: sqlite3_system_errno, 0 when none.
Error error_from_sqlite(int code, int system_errno, const std::string& file,
                        const std::string& doing, const std::string& detail);

template <class F>
auto answered(F&& body) -> Result<std::invoke_result_t<F>> {
  try {
    if constexpr (std::is_void_v<std::invoke_result_t<F>>) {
      body();
      return {};
    } else {
      return body();
    }
  } catch (StorageFailure& failure) {
    return tl::unexpected(std::move(failure.error));
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::resource_exhausted, reasons::kOutOfMemory,
                "the store ran out of memory; nothing was written");
  } catch (const std::exception& bug) {
    return fail(ErrorCode::internal, reasons::kBug,
                std::string("the store met a bug: ") + bug.what() + ": please report it");
  }
}

}  // namespace driftwise::storage
