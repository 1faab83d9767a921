// Opening: new, read-only, foreign, newer, damaged, and held by another daemon.

#include <fstream>
#include <thread>

#include "storage/schema/schema.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using OpeningTest = StoreTest;

std::int64_t number(const std::string& path, const char* sql) {
  Database db(path, SQLITE_OPEN_READWRITE, "");
  Query query(db, sql);
  EXPECT_TRUE(query.row());
  return query.integer(0);
}

TEST_F(OpeningTest, WritesInWalModeWithFullSynchronisation) {
  EXPECT_EQ(number(path, "SELECT count(*) FROM pragma_journal_mode WHERE journal_mode = 'wal'"), 1);
  // What a crash test proves for the system, a power cut test proves for synchronous:
  // tests/faults/power_cut_test.cc.
}

TEST_F(OpeningTest, ReadsWhileTheDaemonWrites) {
  const auto reader = open_store(path, true);
  EXPECT_EQ(reader->points().points(run, 0, 0)->size(), 0u);
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0)));
  EXPECT_EQ(reader->points().points(run, 0, 0)->size(), 1u);
  // Channels that were new to the reader have their names.
  EXPECT_EQ(value_of(reader->points().points(run, 0, 0)->at(0).values, "t05_degC"),
            20.5 + 0.01 * 5);
  EXPECT_EQ(reader->readings().readings("scanner", {0}, at_s(1e6).utc, 0)->size(), 1u);
  const auto refused = reader->points().commit(example_commit(run, datum, 1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(refused.error().reason, "READ_ONLY");
}

TEST_F(OpeningTest, ReadsInAnotherThreadDuringAStreamOfCommits) {
  const auto reader = open_store(path, true);
  std::thread reading([&] {
    std::size_t before = 0;
    while (before < 50) {
      const auto points = reader->points().points(run, 0, 0);
      ASSERT_TRUE(points) << points.error().message;
      ASSERT_GE(points->size(), before);
      for (const auto& point : *points) ASSERT_EQ(point.values.size(), 12u);
      before = points->size();
      const auto record = reader->runs().run(run);
      ASSERT_TRUE(record);
      ASSERT_GE(record->accepted, static_cast<std::int64_t>(before));
    }
  });
  for (int row = 0; row < 50; ++row) {
    EXPECT_TRUE(store->points().commit(example_commit(run, datum, row)));
    EXPECT_TRUE(store->idle());
  }
  reading.join();
}

TEST_F(OpeningTest, RefusesASecondWriterAndNamesTheFirst) {
  const auto second = open_sqlite_store(path, false);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(second.error().reason, "DATABASE_IN_USE");
  EXPECT_THAT(second.error().message, testing::HasSubstr(std::to_string(getpid())));
  store.reset();
  EXPECT_TRUE(open_sqlite_store(path, false));
}

// One file has one lock, whatever it is called, and nothing that could be deleted holds it.
TEST_F(OpeningTest, RefusesASecondWriterByEveryNameOfTheFile) {
  std::filesystem::create_symlink(path, folder / "symbolic.db");
  std::filesystem::create_hard_link(path, folder / "hard.db");
  for (const char* name : {"symbolic.db", "hard.db", "./cell.db"})
    EXPECT_EQ(open_sqlite_store(folder / name, false).error().reason, "DATABASE_IN_USE") << name;
  EXPECT_FALSE(std::filesystem::exists(path + ".lock"));
  // Another file at the same path is another database.
  std::filesystem::rename(path, folder / "moved.db");
  EXPECT_EQ(open_sqlite_store(folder / "moved.db", false).error().reason, "DATABASE_IN_USE");
  std::filesystem::rename(folder / "moved.db", path);
  store.reset();
  EXPECT_TRUE(open_sqlite_store(folder / "hard.db", false));
}

TEST_F(OpeningTest, SaysThatAShellHoldsTheDatabase) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .busy_timeout_ms = 20});
  Database shell(path, SQLITE_OPEN_READWRITE, "");
  shell.execute("BEGIN IMMEDIATE");
  const auto refused = store->points().commit(example_commit(run, datum, 0));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "DATABASE_LOCKED");
  shell.execute("ROLLBACK");
  EXPECT_TRUE(store->points().commit(example_commit(run, datum, 0)));
}

TEST_F(OpeningTest, RefusesToReadWhatIsNotThere) {
  const auto missing = open_sqlite_store(folder / "none.db", true);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_THAT(missing.error().message, testing::HasSubstr("none.db"));
  EXPECT_EQ(open_sqlite_store(folder / "no/such/folder.db", false).error().code,
            ErrorCode::not_found);
}

TEST_F(OpeningTest, RefusesANewerSchemaWithASentence) {
  store.reset();
  Database(path, SQLITE_OPEN_READWRITE, "").execute("PRAGMA user_version = 99");
  for (const bool read_only : {false, true}) {
    const auto newer = open_sqlite_store(path, read_only);
    ASSERT_FALSE(newer);
    EXPECT_EQ(newer.error().code, ErrorCode::failed_precondition);
    EXPECT_EQ(newer.error().reason, "SCHEMA_NEWER");
    EXPECT_THAT(newer.error().message, testing::HasSubstr("99"));
  }
}

TEST_F(OpeningTest, LeavesADatabaseOfSomebodyElseAlone) {
  const std::string other = folder / "photos.db";
  Database(other, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "")
      .execute("CREATE TABLE photo (name TEXT)");
  const auto refused = open_sqlite_store(other, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NOT_DRIFTWISE");
  EXPECT_EQ(number(other, "SELECT count(*) FROM sqlite_schema"), 1);
  EXPECT_EQ(number(other, "SELECT count(*) FROM pragma_journal_mode WHERE journal_mode = 'delete'"),
            1);
}

TEST_F(OpeningTest, NamesADamagedFile) {
  const std::string noise = folder / "noise.db";
  std::ofstream(noise) << std::string(8192, 'x');
  for (const bool read_only : {false, true}) {
    const auto damaged = open_sqlite_store(noise, read_only);
    ASSERT_FALSE(damaged);
    EXPECT_EQ(damaged.error().code, ErrorCode::data_loss);
    EXPECT_EQ(damaged.error().reason, "DATABASE_DAMAGED");
    EXPECT_THAT(damaged.error().message, testing::HasSubstr("noise.db"));
  }
}

TEST_F(OpeningTest, FindsDamageInsideWhenItIsRead) {
  for (int row = 0; row < 200; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  store.reset();
  {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
    for (std::streamoff page = 40 * 4096; page < size; page += 4096) {
      file.seekp(page);
      file << std::string(64, '\xff');
    }
  }
  const auto reader = open_store(path, true);
  const auto points = reader->points().points(run, 0, 0);
  ASSERT_FALSE(points);
  EXPECT_EQ(points.error().code, ErrorCode::data_loss);
  EXPECT_THAT(points.error().message, testing::HasSubstr(path));
}

TEST_F(OpeningTest, MovesTheLogIntoTheDatabaseBetweenPoints) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .checkpoint_pages = 40});
  const auto log_bytes = [&] { return std::filesystem::file_size(path + "-wal"); };
  const auto fill = [&](int from, int to) {
    for (int row = from; row < to; ++row) {
      ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
      ASSERT_TRUE(store->idle());
    }
  };
  fill(0, 300);
  // One step of the summaries of series is the most that it holds.
  EXPECT_LT(log_bytes(), 400u * 4120u);
  fill(300, 900);
  EXPECT_LT(log_bytes(), 400u * 4120u) << "reused from its beginning, not grown";
}

TEST_F(OpeningTest, KeepsTheLogBoundedWhenNobodyIsEverIdle) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .checkpoint_pages = 5});
  for (int row = 0; row < 300; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  EXPECT_LT(std::filesystem::file_size(path + "-wal"), (5u * 16u + 40u) * 4120u);
}

TEST(MemoryStore, WorksForTests) {
  const auto store = open_store(":memory:");
  EXPECT_TRUE(store->runs().create_run(example_run()));
  EXPECT_TRUE(store->idle());
}

}  // namespace
}  // namespace driftwise::storage
