// The database's files under a whole cell: a log that is deleted, a file that is moved, pages that
// are damaged, a model that was changed.

#include <gmock/gmock.h>

#include <fstream>
#include <optional>
#include <utility>

#include "storage/sqlite/database.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"
#include "tests/unit/storage/sqlite/disk_without_room.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class DatabaseUpkeepInACell : public testing::Test {
 protected:
  Folder folder;
  const std::string path = folder / "cell.sqlite";
  SmallWorld world;
  int refused_openings = 0;  // of a store for reading, from now on
  OpenStore open = [this](const std::string& database,
                          bool read_only) -> Result<std::unique_ptr<Store>> {
    if (read_only && refused_openings > 0 && refused_openings-- > 0)
      return fail(ErrorCode::resource_exhausted, "NO_FILES", "too many open files");
    return storage::open_sqlite_store(database, read_only, {.vfs = "", .busy_timeout_ms = 0});
  };
  std::optional<CellInMemory> cell_;
  CellTime begin = kWorldBegin;

  CellInMemory& cell() {
    if (!cell_) cell_.emplace(world, small_cell(path), open, begin);
    return *cell_;
  }
  // Ended in good order and started again, an hour later.
  void restart() {
    begin = cell().now() + std::chrono::hours(1);
    cell_.reset();
    cell();
  }
  std::vector<std::string> alarms(const std::string& kind) { return cell().alarms_of(kind); }
  RunRecord begin_and_accept(int count) {
    auto run = cell().begin_run(lines_of(2, {2, -3, 1}, true));
    cell().until([&] { return cell().status().run->run.accepted == count; });
    return run;
  }
  std::string copy() {
    for (const auto& entry : fs::directory_iterator(fs::path(path).parent_path()))
      if (entry.path().filename().string().find(".kept-") != std::string::npos)
        return entry.path().string();
    return {};
  }
  static std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::int64_t number(const std::string& sql) {
    storage::Database db(path, SQLITE_OPEN_READONLY, "");
    std::string found;
    db.for_each_row(sql, [&](const std::string& text) { found = text; });
    return found.empty() ? 0 : std::stoll(found);
  }
  void damage(std::int64_t page) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp((page - 1) * 4096);
    file << std::string(64, '\xff');
  }
};

TEST_F(DatabaseUpkeepInACell, ADeletedLogCostsNothingAndIsToldOf) {
  const auto run = begin_and_accept(3);
  fs::remove(path + "-wal");
  const auto ended = cell().finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 100))->size(), 8u);
  EXPECT_THAT(cell().events_named("database.log_gone"), SizeIs(1));
  ASSERT_THAT(alarms("database.log_gone"), SizeIs(1));
  EXPECT_THAT(alarms("database.log_gone").front(), HasSubstr("a new one is in use"));
  EXPECT_TRUE(fs::exists(path + "-wal"));
}

TEST_F(DatabaseUpkeepInACell, ADeletedLogOnAFullDiskWaitsForRoomAndLosesNothing) {
  const auto run = begin_and_accept(3);
  std::optional<storage::DiskWithoutRoom> full(std::in_place);
  fs::remove(path + "-wal");
  cell().until([&] { return cell().status().run->run.state == RunState::waiting; }, 300);
  cell().pass(120);
  ASSERT_THAT(alarms("database.log_gone"), SizeIs(1));
  EXPECT_THAT(alarms("database.log_gone").front(), HasSubstr("do not end the daemon"));
  EXPECT_THAT(alarms("database.log_gone").front(), HasSubstr("the disk is full"));
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 100))->size(), 3u) << "queries are answered";
  full.reset();
  const auto ended = cell().finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 100))->size(), 8u);
  EXPECT_THAT(alarms("database.log_gone").front(), HasSubstr("a new one is in use"));
  EXPECT_THAT(cell().events_named("database.log_gone"), SizeIs(2)) << "that, and its end";
  EXPECT_THAT(alarms("database.files"), IsEmpty()) << "no other program wrote anything";
  cell().shut_down();
  const auto report = (*kSqlite(path, true))->audit().verify({}, {});
  EXPECT_TRUE(report->intact()) << report->first.front();
}

TEST_F(DatabaseUpkeepInACell, ADeletedLogUnderAForeignReaderWaitsForItsEndAndLosesNothing) {
  const auto run = begin_and_accept(2);
  storage::Database shell(path, SQLITE_OPEN_READONLY, "");
  shell.execute("BEGIN; SELECT count(*) FROM point");
  cell().until([&] { return cell().status().run->run.accepted == 3; });
  fs::remove(path + "-wal");
  cell().until([&] { return cell().status().run->run.state == RunState::waiting; }, 300);
  cell().pass(60);
  EXPECT_THAT(alarms("database.log_gone"),
              testing::ElementsAre(HasSubstr("another program holds the database")));
  shell.execute("COMMIT");
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 100))->size(), 8u);
}

TEST_F(DatabaseUpkeepInACell, QueriesGoOnAfterAReaderThatCouldNotBeOpenedAtFirst) {
  const auto run = begin_and_accept(3);
  refused_openings = 5;
  fs::remove(path + "-wal");
  cell().until([&] { return refused_openings < 4; }, 300);
  const auto told = alarms("database.log_gone");
  EXPECT_THAT(told, testing::Contains(HasSubstr("queries wait")));
  EXPECT_THAT(told, testing::Contains(HasSubstr("too many open files")));
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 3))->size(), 3u);
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(alarms("database.log_gone"), SizeIs(1)) << "nothing waits any more";
}

TEST_F(DatabaseUpkeepInACell, ACopyThatFoundNoRoomIsMadeWhenThereIsSome) {
  const auto run = begin_and_accept(3);
  std::optional<storage::DiskWithoutRoom> full(std::in_place);
  fs::rename(path, folder / "elsewhere.sqlite");
  cell().until([&] { return !alarms("database.files").empty(); }, 300);
  EXPECT_THAT(alarms("database.files").front(), HasSubstr("is tried again every minute"));
  cell().pass(120);
  EXPECT_EQ(copy(), "") << "an empty file is no copy";
  full.reset();
  cell().pass(90);
  ASSERT_NE(copy(), "");
  EXPECT_THAT(alarms("database.files").front(), HasSubstr(copy()));
  EXPECT_EQ((*kSqlite(copy(), true))->points().points(run.id, 0, 100)->size(), 3u);
}

TEST_F(DatabaseUpkeepInACell, AMovedFileStopsTheRunUntilItIsBack) {
  const auto run = begin_and_accept(3);
  fs::rename(path, folder / "elsewhere.sqlite");
  cell().until([&] { return cell().status().run->run.state == RunState::waiting; }, 300);
  const auto accepted = cell().status().run->run.accepted;
  EXPECT_EQ(accepted, 3) << "no point is accepted that is not stored";
  cell().pass(600);
  EXPECT_EQ(cell().status().run->run.accepted, accepted);
  const auto told = alarms("database.files");
  ASSERT_THAT(told, SizeIs(1));
  EXPECT_THAT(told.front(), HasSubstr("is no longer at its path"));
  EXPECT_THAT(told.front(), HasSubstr("put the file back"));
  ASSERT_NE(copy(), "");
  EXPECT_THAT(told.front(), HasSubstr(copy()));
  EXPECT_EQ((*kSqlite(copy(), true))->points().points(run.id, 0, 100)->size(), 3u);

  fs::rename(folder / "elsewhere.sqlite", path);
  const auto ended = cell().finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(cell().await(cell().points(run.id, 0, 100))->size(), 8u);
  cell().pass(30);
  EXPECT_THAT(alarms("database.files"), IsEmpty());
}

TEST_F(DatabaseUpkeepInACell, AFileInItsPlaceIsNotWritten) {
  begin_and_accept(3);
  { const auto other = *kSqlite(folder / "other.sqlite", false); }
  const auto before = bytes_of(folder / "other.sqlite");
  fs::rename(folder / "other.sqlite", path);
  cell().until([&] { return cell().status().run->run.state == RunState::waiting; }, 300);
  cell().pass(30);
  EXPECT_TRUE(bytes_of(path) == before);
  ASSERT_THAT(alarms("database.files"), SizeIs(1));
  EXPECT_THAT(alarms("database.files").front(), HasSubstr("replaced by another file"));
}

TEST_F(DatabaseUpkeepInACell, ChecksThePagesAtIdleAndTellsWhenTheyWereClean) {
  begin_and_accept(3);
  EXPECT_EQ(cell().status().database.last_clean.utc_ns, 0);
  cell().finish_run();
  cell().pass(300);
  const auto clean = cell().status().database;
  EXPECT_GT(clean.last_clean.utc_ns, 0);
  EXPECT_THAT(clean.troubles, IsEmpty());
  EXPECT_GT(clean.tables, 20);
  EXPECT_EQ(clean.tables_checked, clean.tables);
  restart();
  cell().pass(5);
  EXPECT_EQ(cell().status().database.last_clean, clean.last_clean) << "still said after a restart";
}

TEST_F(DatabaseUpkeepInACell, ContinuesTheCheckAfterARestart) {
  begin_and_accept(1);
  cell().finish_run();
  cell().until([&] { return cell().status().database.tables_checked == 6; }, 300);
  restart();
  cell().pass(300);
  EXPECT_GT(cell().status().database.last_clean.utc_ns, 0);
  cell().shut_down();
  const auto half_an_hour = begin - std::chrono::minutes(30);
  EXPECT_EQ(number("SELECT count(*) FROM database_check WHERE checked_ns < " +
                   std::to_string(half_an_hour.utc_ns)),
            6)
      << "checked before the restart, and not again";
}

TEST_F(DatabaseUpkeepInACell, FindsDamageThatHappenedWhileItWasAway) {
  begin_and_accept(3);
  cell().finish_run();
  cell().pass(300);
  const auto clean = cell().status().database.last_clean;
  begin = cell().now() + std::chrono::hours(48);
  cell_.reset();
  damage(number("SELECT rootpage FROM sqlite_schema WHERE name = 'attempt'"));
  cell().pass(3600);
  EXPECT_EQ(cell().status().database.last_clean, clean);
  ASSERT_THAT(cell().status().database.troubles, SizeIs(1));
  EXPECT_THAT(cell().status().database.troubles.front(), HasSubstr("table attempt"));
  EXPECT_THAT(alarms("database.damaged"), SizeIs(1));
}

TEST_F(DatabaseUpkeepInACell, AClockThatWasSetBackBeginsTheCheckAnew) {
  begin_and_accept(1);
  cell().finish_run();
  cell().pass(300);
  const auto before = cell().status().database.last_clean;
  ASSERT_GT(before.utc_ns, 0);
  begin = cell().now() - std::chrono::hours(3);  // every table was checked later than this
  cell_.reset();
  cell().pass(300);
  const auto again = cell().status().database;
  EXPECT_EQ(again.tables_checked, again.tables);
  EXPECT_LT(again.last_clean, before);
}

TEST_F(DatabaseUpkeepInACell, ACheckWaitsWhileTheRobotIsAtWork) {
  begin_and_accept(2);
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, cell().status().run->run.id)));
  cell().pass(7200);
  EXPECT_EQ(cell().status().database.tables_checked, 0);
  cell().pass(86400);
  EXPECT_GT(cell().status().database.tables_checked, 0) << "a day late at most";
}

}  // namespace
}  // namespace driftwise::tests
