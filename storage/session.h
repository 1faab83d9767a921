#pragma once
// What the parts of one store share: the connection, the names, and how a call begins and ends.

#include <string>
#include <type_traits>
#include <utility>

#include "storage/database.h"
#include "storage/failure.h"
#include "storage/lock_file.h"
#include "storage/names.h"

namespace driftwise::storage {

struct Session {
  LockFile lock;  // released after the connection is closed
  Database db;
  Names names;
  bool read_only;

  Session(LockFile taken, const std::string& path, int flags, const std::string& vfs,
          bool reads_only)
      : lock(std::move(taken)), db(path, flags, vfs), names(db), read_only(reads_only) {}

  // Runs body in one transaction, durable when this returns; any failure leaves the database as it
  // was.
  template <class F>
  auto write(F&& body) -> Result<std::invoke_result_t<F>> {
    auto result = answered([&]() -> std::invoke_result_t<F> {
      require_writable();
      Transaction transaction(db);
      if constexpr (std::is_void_v<std::invoke_result_t<F>>) {
        body();
        end(transaction);
      } else {
        auto value = body();
        end(transaction);
        return value;
      }
    });
    if (!result) names.forget();
    return result;
  }

  // Runs body on one unchanging view of the database.
  template <class F>
  auto read(F&& body) -> Result<std::invoke_result_t<F>> {
    return answered([&] {
      Transaction transaction(db, Transaction::Kind::read);
      auto value = body();
      transaction.commit();
      return value;
    });
  }

 private:
  void end(Transaction& transaction) {
    names.refresh_views();
    transaction.commit();
  }
  void require_writable() const {
    if (read_only)
      throw_failure(ErrorCode::failed_precondition, "READ_ONLY",
                    "database " + db.path() +
                        " was opened for reading: write through the store that the daemon opened");
  }
};

}  // namespace driftwise::storage
