// A disk that fills up or fails during a call: the call says so, nothing of it is stored, and once
// there is room the same call succeeds.

#include <cerrno>

#include "tests/faults/unsynced_vfs.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::faults {
namespace {

using storage::at_s;
using storage::example_commit;
using storage::open_store;

enum class Part { writes, syncs };

struct Case {
  const char* name;
  Part part;
  int sqlite_code;
  int system_errno;
  ErrorCode expected;
  const char* reason;
};

class FailingDisk : public testing::TestWithParam<Case> {
 protected:
  void fail_from(std::int64_t change) {
    if (GetParam().part == Part::writes)
      disk.fail_writes_from(change, GetParam().sqlite_code, GetParam().system_errno);
    else
      disk.fail_syncs_from(change, GetParam().sqlite_code, GetParam().system_errno);
  }
  void expect_expected(const Error& error) const {
    EXPECT_EQ(error.code, GetParam().expected) << error.message;
    EXPECT_EQ(error.reason, GetParam().reason);
    EXPECT_THAT(error.message, testing::HasSubstr("cell.db"));
  }

  UnsyncedVfs disk{"failing"};
  storage::TemporaryFolder folder;
  std::string path = folder / "cell.db";
};

TEST_P(FailingDisk, FailsThePointWholeAndTakesItAfterwards) {
  auto store = open_store(path, false, {.vfs = disk.name(), .checkpoint_pages = 1000000});
  const RunId run = store->runs().create_run(storage::example_run()).value().id;
  const DatumId datum = store->points().open_datum(storage::example_datum(run)).value();
  int failures = 0;
  for (std::int64_t row = 0; row < 40; ++row) {
    const PointCommit commit = example_commit(run, datum, row);
    fail_from(disk.changes() + 1 +
              row);  // one change later each time, until the commit gets through
    const auto failed = store->points().commit(commit);
    disk.heal();
    if (!failed) {
      ++failures;
      expect_expected(failed.error());
      EXPECT_EQ(store->runs().run(run)->accepted, row);
      EXPECT_EQ(store->points().points(run, 0, 0)->size(), static_cast<std::size_t>(row));
      const auto again = store->points().commit(commit);
      ASSERT_TRUE(again) << again.error().message;
    }
    EXPECT_EQ(store->runs().run(run)->accepted, row + 1);
  }
  RecordProperty("faults", failures);
  EXPECT_GE(failures, 5);  // each of the first commits was hit
  store.reset();
  store = open_store(path, false, {.vfs = disk.name()});
  EXPECT_EQ(store->points().points(run, 0, 0)->size(), 40u);
  EXPECT_EQ(store->readings().readings("scanner", {0}, at_s(1e9).utc, 0)->size(), 40u);
}

TEST_P(FailingDisk, FailsTheCheckpointAndLosesNothing) {
  auto store = open_store(path, false, {.vfs = disk.name(), .checkpoint_pages = 30});
  const RunId run = store->runs().create_run(storage::example_run()).value().id;
  const DatumId datum = store->points().open_datum(storage::example_datum(run)).value();
  for (int row = 0; row < 10; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  fail_from(disk.changes() + 1);
  const auto checkpoint = store->idle();
  ASSERT_FALSE(checkpoint);
  expect_expected(checkpoint.error());
  disk.heal();
  EXPECT_EQ(store->points().points(run, 0, 0)->size(), 10u);
  EXPECT_TRUE(store->idle());
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 10)));
}

TEST_P(FailingDisk, FailsTheOpeningOfANewDatabase) {
  int failures = 0;
  for (std::int64_t change = 1; change < 1000; change += 1 + change / 8) {
    storage::TemporaryFolder fresh;
    fail_from(disk.changes() + change);
    const auto opened = storage::open_sqlite_store(fresh / "cell.db", false, {.vfs = disk.name()});
    disk.heal();
    if (opened) {
      EXPECT_GT(change, 1);
      RecordProperty("faults", failures);
      return;
    }
    ++failures;
    expect_expected(opened.error());
    const auto again = storage::open_sqlite_store(fresh / "cell.db", false, {.vfs = disk.name()});
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_TRUE((*again)->runs().create_run(storage::example_run()));
  }
  FAIL() << "opening a database takes more changes than expected";
}

// SQLite answers SQLITE_FULL to a write without room, and an I/O error with the system's errno to
// everything else: ext4 finds out at an fsync that there is no room, and after an error of its own
// it refuses every write with EROFS.
INSTANTIATE_TEST_SUITE_P(Table, FailingDisk,
                         testing::Values(Case{"Full", Part::writes, SQLITE_FULL, ENOSPC,
                                              ErrorCode::resource_exhausted, "DISK_FULL"},
                                         Case{"FullAtTheSync", Part::syncs, SQLITE_IOERR_FSYNC,
                                              ENOSPC, ErrorCode::resource_exhausted, "DISK_FULL"},
                                         Case{"BecameReadOnly", Part::writes, SQLITE_IOERR_WRITE,
                                              EROFS, ErrorCode::resource_exhausted, "READ_ONLY"},
                                         Case{"ReadOnlyAtTheSync", Part::syncs, SQLITE_IOERR_FSYNC,
                                              EROFS, ErrorCode::resource_exhausted, "READ_ONLY"},
                                         Case{"WriteError", Part::writes, SQLITE_IOERR_WRITE, EIO,
                                              ErrorCode::data_loss, "DISK_ERROR"},
                                         Case{"SyncError", Part::syncs, SQLITE_IOERR_FSYNC, EIO,
                                              ErrorCode::data_loss, "DISK_ERROR"}),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise::faults
