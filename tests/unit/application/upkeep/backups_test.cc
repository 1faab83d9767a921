// Backups by the cell file's schedule and when asked, and the forecast of a disk that fills up.

#include "server/application/upkeep/backups.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "server/application/upkeep/disk_forecast.h"
#include "server/application/upkeep/record_keeping.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class BackupsInACell : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  std::optional<CellInMemory> cell_;

  CellInMemory& cell(BackupRules rules) {
    auto description = small_cell(folder / "cell.sqlite");
    description.backup = std::move(rules);
    return cell_.emplace(world, description, kSqlite, kWorldBegin);
  }
  std::string identity() const {
    return kSqlite(folder / "cell.sqlite", true).value()->records().database_id().value();
  }
  // "kept/cell-0f3a9c1d2e4b5061-20261122-093000.db"
  std::string own_copy(const std::string& instant) const {
    return folder / ("kept/cell-" + identity() + "-" + instant + ".db");
  }
  std::vector<std::string> files(const std::string& extension) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / "kept"))
      if (entry.path().extension() == extension) names.push_back(entry.path().string());
    std::ranges::sort(names);
    return names;
  }
};

TEST_F(BackupsInACell, AreMadeByTheScheduleAndTheNewestStay) {
  auto& running = cell({folder / "kept", 2, 3});
  running.pass(9 * 3600);
  ASSERT_THAT(files(".db"), SizeIs(3));
  EXPECT_THAT(files(".head"), SizeIs(3));
  EXPECT_THAT(running.events_named("backup.made"), SizeIs(testing::Ge(4)));
  EXPECT_THAT(running.events_named("backup.removed"), testing::Not(IsEmpty()));
  const auto newest = kSqlite(files(".db").back(), true).value();
  EXPECT_TRUE(newest->audit().verify({}, {})->intact());
}

TEST_F(BackupsInACell, AreMadeWhileARunIsUnderWayWhenSomebodyAsks) {
  auto& running = cell({folder / "kept", 0, 3});
  running.begin_run(lines_of(2, {2, -3, 1}, true));
  running.until([&] { return running.status().run->run.accepted == 3; });
  const auto made = running.await(running->keeping.back_up(running.ada));
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(kSqlite(made->path, true).value()->points().points(RunId{1}, 0, 0)->size(), 3U);
  EXPECT_EQ(running.finish_run().state, RunState::done);
  EXPECT_THAT(running.events_named("backup.made"), SizeIs(1));
}

TEST_F(BackupsInACell, ThatFailAreAnAlarmUntilOneIsMade) {
  std::ofstream(folder / "kept") << "a file where the folder should be";
  auto& running = cell({folder / "kept", 2, 3});
  running.pass(600);
  ASSERT_THAT(running.alarms_of("backup.failed"), SizeIs(1));
  EXPECT_THAT(running.alarms_of("backup.failed").front(), HasSubstr("kept"));
  fs::remove(folder / "kept");
  running.pass(2 * 3600);
  EXPECT_THAT(running.alarms_of("backup.failed"), IsEmpty());
  EXPECT_THAT(files(".db"), testing::Not(IsEmpty()));
}

TEST_F(BackupsInACell, ABackupOfAClockThatWasAheadKeepsNoOtherFromBeingMade) {
  fs::create_directories(folder / "kept");
  auto& running = cell({folder / "kept", 2, 2});
  std::ofstream(own_copy("20990101-000000")) << "made while the computer was in 2099";
  running.pass(9 * 3600);
  EXPECT_THAT(running.events_named("backup.made"), SizeIs(testing::Ge(4)));
  ASSERT_THAT(files(".db"), SizeIs(2));
  EXPECT_THAT(files(".db"), testing::Each(testing::Not(HasSubstr("2099")))) << "it is the oldest";
}

// Every template of a cell file names the same database, and a share holds the copies of all cells.
TEST_F(BackupsInACell, OfAnotherCellInTheSameFolderAreNeitherCountedNorRemoved) {
  fs::create_directories(folder / "kept");
  const std::string others = folder / "other.sqlite";
  auto other = kSqlite(others, false).value();
  const std::string of_before = folder / "kept/cell-20261122-120000.db",
                    of_now = folder / "kept/cell-0123456789abcdef-20261122-120000.db";
  ASSERT_TRUE(other->audit().back_up(of_before, {}));
  fs::copy_file(of_before, of_now);
  auto& running = cell({folder / "kept", 2, 2});
  running.pass(600);
  EXPECT_THAT(running.events_named("backup.made"), SizeIs(1)) << "it had none of its own";
  running.pass(9 * 3600);
  EXPECT_TRUE(fs::exists(of_before));
  EXPECT_TRUE(fs::exists(of_now));
  EXPECT_THAT(files(".db"), SizeIs(2 + 2)) << "two of its own";
}

TEST_F(BackupsInACell, OfAnEarlierProgramAreItsOwnByWhatTheyHold) {
  auto& running = cell({folder / "kept", 2, 2});
  running.pass(600);
  ASSERT_THAT(files(".db"), SizeIs(1));
  const std::string of_before = folder / "kept/cell-20200101-000000.db";
  fs::copy_file(files(".db").front(), of_before);
  running.pass(9 * 3600);
  EXPECT_FALSE(fs::exists(of_before)) << "the oldest of its own";
  EXPECT_THAT(files(".db"), SizeIs(2));
}

TEST_F(BackupsInACell, ThatWereKilledOnTheWayLeaveNothingForLong) {
  cell({"", 0, 3}).shut_down();
  fs::create_directories(folder / "kept");
  const auto part = own_copy("20261122-093000") + ".part";
  const std::string others = folder / "kept/cell-0123456789abcdef-20261122-093000.db.part";
  for (const auto& file : {part, part + "-journal", others}) std::ofstream(file) << "half";
  auto& running = cell({folder / "kept", 0, 3});
  running.pass(10);
  EXPECT_FALSE(fs::exists(part));
  EXPECT_FALSE(fs::exists(part + "-journal"));
  EXPECT_TRUE(fs::exists(others)) << "another cell may be making it";
}

// The name of the backup is longer than a file system takes, so that nobody can say whether there
// is such a file: as in a folder that cannot be searched, which root would search all the same.
TEST_F(BackupsInACell, ThatCannotBeLookedForAreAnAlarmAndAreTriedAgain) {
  auto description = small_cell(folder / (std::string(240, 'c') + ".sqlite"));
  description.backup = {folder / "kept", 2, 3};
  auto& running = cell_.emplace(world, description, kSqlite, kWorldBegin);
  running.pass(600);
  ASSERT_THAT(running.alarms_of("backup.failed"), SizeIs(1));
  EXPECT_THAT(running.alarms_of("backup.failed").front(), HasSubstr("cannot be looked for"));
  const auto asked = running.await(running->keeping.back_up(running.ada));
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().reason, "CANNOT_OPEN") << "and no backup is under way for good";
  running.pass(2 * 3600);
  EXPECT_THAT(running.alarms_of("backup.failed"), SizeIs(1)) << "the cell works on";
}

constexpr std::int64_t kMega = 1'000'000, kGiga = 1'000'000'000;

CellTime at_h(double hours) { return CellTime{0} + nanoseconds_from_s(hours * 3600); }

TEST(DiskForecast, NeedsAnHourAndGrowth) {
  application::DiskForecast forecast;
  forecast.take({at_h(0), 100 * kMega, 226 * kMega}, {});
  forecast.take({at_h(0.5), 101 * kMega, 225 * kMega}, {});
  EXPECT_FALSE(forecast.days());
  forecast.take({at_h(2), 110 * kMega, 216 * kMega}, {});
  EXPECT_DOUBLE_EQ(forecast.bytes_per_hour(), 5e6);
  EXPECT_DOUBLE_EQ(*forecast.days(), 1.8);
  EXPECT_THAT(forecast.warning("cell.db"), HasSubstr("the disk of cell.db is full in 43 hours"));
}

TEST(DiskForecast, GoesByTheLastDayAndIsSilentWhileThereIsRoom) {
  application::DiskForecast forecast;
  // A day of 10 MB an hour, then two of 1 MB an hour.
  std::int64_t bytes = 0;
  for (int hour = 0; hour <= 72; ++hour) {
    forecast.take({at_h(hour), bytes, 504 * kMega - bytes}, {});
    bytes += hour < 24 ? 10 * kMega : kMega;
  }
  EXPECT_DOUBLE_EQ(forecast.bytes_per_hour(), 1e6);
  EXPECT_THAT(forecast.warning("cell.db"), HasSubstr("is full in 9 days"));
  forecast.take({at_h(73), bytes, 1000 * kGiga}, {});
  EXPECT_THAT(forecast.warning("cell.db"), IsEmpty());
}

TEST(DiskForecast, SeesWhatOtherProgramsWriteToTheSameDisk) {
  application::DiskForecast forecast;
  forecast.take({at_h(0), 100 * kMega, 20 * kGiga}, {});
  forecast.take({at_h(24), 101 * kMega, 18 * kGiga}, {});
  EXPECT_DOUBLE_EQ(*forecast.days(), 9);
}

// 21 GB that grow by 57.5 MB a day, a copy each day, 14 kept: the eighth does not fit.
TEST(DiskForecast, CountsTheBackupsThatTheScheduleWillStillAdd) {
  application::DiskForecast forecast;
  forecast.take({at_h(0), 21 * kGiga, 150 * kGiga}, {15, 24});
  EXPECT_DOUBLE_EQ(*forecast.days(), 8) << "known without any growth";
  EXPECT_THAT(forecast.warning("cell.db"),
              HasSubstr("still adds 15 copies of 21000 MB; make room, keep fewer backups"));
  forecast.take({at_h(24), 21 * kGiga + 58 * kMega, 129 * kGiga - 58 * kMega, 21 * kGiga},
                {14, 24});
  EXPECT_DOUBLE_EQ(*forecast.days(), 7);
  EXPECT_NEAR(forecast.bytes_per_hour(), 58e6 / 24, 1) << "the copy is no growth";
}

TEST(DiskForecast, IsSilentWhereEveryCopyOfTheScheduleFits) {
  application::DiskForecast forecast;
  forecast.take({at_h(0), 21 * kGiga, 400 * kGiga}, {15, 24});
  forecast.take({at_h(24), 21 * kGiga + 58 * kMega, 379 * kGiga - 58 * kMega, 21 * kGiga},
                {14, 24});
  EXPECT_GT(*forecast.days(), 1000);
  EXPECT_THAT(forecast.warning("cell.db"), IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
