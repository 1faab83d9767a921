// Meaning of a result code of SQLite and of the system's error for the daemon.

#include "storage/sqlite/failure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cerrno>
#include <stdexcept>

namespace driftwise::storage {
namespace {

Error answer(int code, int system_errno) {
  return error_from_sqlite(code, system_errno, "/cell/cell.db", "commit", "disk I/O error");
}

// write, fsync and ftruncate on an ext4 whose journal ended answer EROFS.
TEST(ADiskThatBecameReadOnly, IsWaitedForAsAFullOneIs) {
  for (const int code : {SQLITE_IOERR_WRITE, SQLITE_IOERR_FSYNC, SQLITE_IOERR_TRUNCATE}) {
    const Error error = answer(code, EROFS);
    EXPECT_EQ(error.code, answer(SQLITE_FULL, 0).code);
    EXPECT_EQ(error.reason, "READ_ONLY");
    EXPECT_THAT(error.message, testing::HasSubstr("mount it for writing"));
    EXPECT_THAT(error.message, testing::HasSubstr("end the daemon, unmount, check (fsck), mount"))
        << "ext4 takes no remount after an error";
  }
}

TEST(ADiskThatAnswersWithAnError, IsNotWaitedFor) {
  const Error error = answer(SQLITE_IOERR_WRITE, EIO);
  EXPECT_EQ(error.code, ErrorCode::data_loss);
  EXPECT_EQ(error.reason, "DISK_ERROR");
}

TEST(AnExceptionThatNobodyExpected, IsAnErrorAtThePort) {
  const auto answer = answered([]() -> int { throw std::runtime_error("no such page"); });
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::internal);
  EXPECT_EQ(answer.error().reason, "BUG");
  EXPECT_THAT(answer.error().message, testing::HasSubstr("no such page"));
}

}  // namespace
}  // namespace driftwise::storage
