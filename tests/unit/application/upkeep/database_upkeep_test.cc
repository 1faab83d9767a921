// The database's files under a whole cell: a log that is deleted, a file that is moved, pages that
// are damaged, a model that was changed.

#include <gmock/gmock.h>

#include <fstream>

#include "storage/sqlite/database.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

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
  std::optional<CellInMemory> cell_;
  CellTime begin = kWorldBegin;

  CellInMemory& cell() {
    if (!cell_) cell_.emplace(world, small_cell(path), kSqlite, begin);
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
