// The database's own files: taken away, replaced, written by others, damaged.

#include <optional>

#include "server/core/records/records.h"
#include "tests/unit/storage/sqlite/disk_without_room.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

namespace fs = std::filesystem;

// A file that another program locks as soon as the last other connection to it is closed.
class ClosedMoment {
 public:
  explicit ClosedMoment(const std::string& path) {
    path_ = path;
    system_open_ = reinterpret_cast<Open>(vfs()->xGetSystemCall(vfs(), kCall));
    replace(reinterpret_cast<sqlite3_syscall_ptr>(&ClosedMoment::open));
  }
  ~ClosedMoment() {
    replace(nullptr);
    other_.reset();
  }
  ClosedMoment(const ClosedMoment&) = delete;
  ClosedMoment& operator=(const ClosedMoment&) = delete;

 private:
  using Open = int (*)(const char*, int, int);
  static constexpr const char* kCall = "open";
  static sqlite3_vfs* vfs() { return sqlite3_vfs_find(nullptr); }
  static void replace(sqlite3_syscall_ptr call) { vfs()->xSetSystemCall(vfs(), kCall, call); }
  static int open(const char* file, int flags, int rights) {
    if (file == path_ && !other_) {
      replace(nullptr);
      other_.emplace(path_, SQLITE_OPEN_READWRITE, "");
      other_->execute("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE");
    }
    return system_open_(file, flags, rights);
  }
  inline static std::string path_;
  inline static std::optional<Database> other_;
  inline static Open system_open_ = nullptr;
};

class UpkeepTest : public StoreTest {
 protected:
  UpkeepStore& upkeep() { return *store->upkeep(); }
  Result<std::optional<PointId>> commit(std::int64_t row) {
    return store->points().commit(example_commit(run, datum, row));
  }
  // What a start would find if the process were killed now: the files as they are on their paths.
  std::size_t points_after_a_kill() {
    const TemporaryFolder grave;
    const std::string copy = grave / "cell.db";
    fs::copy_file(path, copy);
    if (fs::exists(path + "-wal")) fs::copy_file(path + "-wal", copy + "-wal");
    return open_store(copy)->points().points(run, 0, 0)->size();
  }
  void damage(std::streamoff first_page, std::streamoff last_page) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    for (std::streamoff page = first_page; page <= last_page; ++page) {
      file.seekp(page * 4096);
      file << std::string(64, '\xff');
    }
  }
  std::int64_t root_page(const std::string& table) {
    Database db(path, SQLITE_OPEN_READONLY, "");
    std::string page;
    db.for_each_row("SELECT rootpage FROM sqlite_schema WHERE name = '" + table + "'",
                    [&](const std::string& found) { page = found; });
    return std::stoll(page);
  }
};

TEST_F(UpkeepTest, SaysThatTheFolderOfACopyCannotBeSearched) {
  fs::create_symlink("loop", folder / "loop");  // also root cannot search it
  const auto copied = upkeep().copy_to(folder / "loop/cell.db.kept");
  ASSERT_FALSE(copied);
  EXPECT_EQ(copied.error().reason, "CANNOT_OPEN");
  EXPECT_TRUE(commit(0)) << "the record itself takes points";
}

TEST_F(UpkeepTest, NoToldPointIsLostWithADeletedLog) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  ASSERT_EQ(upkeep().files(), DatabaseFiles::good);
  fs::remove(path + "-wal");
  EXPECT_EQ(upkeep().files(), DatabaseFiles::log_gone);
  // The next call is refused, and what was told before it is moved meanwhile.
  const auto refused = commit(5);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(refused.error().reason, "DATABASE_LOG_GONE");
  EXPECT_EQ(points_after_a_kill(), 5u);
  ASSERT_TRUE(upkeep().secure());
  ASSERT_TRUE(upkeep().reopen());
  ASSERT_TRUE(commit(5));
  EXPECT_EQ(points_after_a_kill(), 6u);
}

TEST_F(UpkeepTest, NoToldPointIsLostWithADeletedLogOnAFullDisk) {
  ASSERT_TRUE(upkeep().secure());
  for (int row = 0; row < 50; ++row) ASSERT_TRUE(commit(row));
  {
    const DiskWithoutRoom full;
    fs::remove(path + "-wal");
    EXPECT_EQ(upkeep().secure().error().reason, "DISK_FULL");
    EXPECT_EQ(upkeep().reopen().error().reason, "DISK_FULL") << "the open log is not let go of";
    EXPECT_EQ(commit(50).error().reason, "DATABASE_LOG_GONE") << "nothing more is told";
  }
  ASSERT_TRUE(upkeep().secure()) << "there is room again";
  ASSERT_TRUE(upkeep().reopen());
  EXPECT_EQ(upkeep().files(), DatabaseFiles::good);
  ASSERT_TRUE(commit(50));
  EXPECT_EQ(points_after_a_kill(), 51u);
  EXPECT_TRUE(store->audit().verify({}, {})->intact());
}

class AForeignReader : public UpkeepTest, public testing::WithParamInterface<bool> {};

TEST_P(AForeignReader, KeepsTheOpenLogAliveUntilItsTransactionEnds) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .busy_timeout_ms = 0});
  for (int row = 0; row < 50; ++row) ASSERT_TRUE(commit(row));
  if (GetParam()) {
    ASSERT_TRUE(upkeep().secure());
  }
  std::optional<Database> shell(std::in_place, path, SQLITE_OPEN_READONLY, "");
  shell->execute("BEGIN; SELECT count(*) FROM point");
  for (int row = 50; row < 60; ++row) ASSERT_TRUE(commit(row));
  fs::remove(path + "-wal");
  EXPECT_EQ(upkeep().secure().error().reason, "DATABASE_LOCKED");
  EXPECT_EQ(upkeep().reopen().error().reason, "DATABASE_LOCKED");
  EXPECT_EQ(commit(60).error().reason, "DATABASE_LOG_GONE");
  EXPECT_EQ(store->points().points(run, 0, 0)->size(), 60u);
  shell->execute("COMMIT");
  ASSERT_TRUE(upkeep().secure());
  ASSERT_TRUE(upkeep().reopen());
  ASSERT_TRUE(commit(60));
  EXPECT_EQ(points_after_a_kill(), 61u);
  EXPECT_TRUE(store->audit().verify({}, {})->intact());
}

INSTANTIATE_TEST_SUITE_P(Table, AForeignReader, testing::Bool(), [](const auto& row) {
  return std::string(row.param ? "OfTheDatabase" : "OfTheLog");
});

TEST_F(UpkeepTest, AViewOfTheNewestStateKeepsTheLogToo) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .busy_timeout_ms = 0});
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  Database shell(path, SQLITE_OPEN_READONLY, "");
  shell.execute("BEGIN; SELECT count(*) FROM point");
  fs::remove(path + "-wal");
  // With the index of that log in use, a new log would begin where the old one ended: after a kill
  // nothing in it could be read.
  EXPECT_EQ(upkeep().reopen().error().reason, "DATABASE_LOCKED");
  shell.execute("COMMIT");
  ASSERT_TRUE(upkeep().reopen());
  ASSERT_TRUE(commit(5));
  EXPECT_EQ(points_after_a_kill(), 6u);
}

TEST_F(UpkeepTest, AReopeningThatFailsHalfWayTakesNoPointUntilItSucceeds) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .busy_timeout_ms = 0});
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  fs::remove(path + "-wal");
  ASSERT_TRUE(upkeep().secure());
  {
    // Another program gets hold of the file in the moment in which the daemon has it closed.
    ClosedMoment moment(path);
    const auto reopened = upkeep().reopen();
    ASSERT_FALSE(reopened);
    EXPECT_EQ(reopened.error().reason, "DATABASE_LOCKED");
  }
  const auto refused = commit(5);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "DATABASE_CLOSED");
  EXPECT_EQ(store->idle().error().reason, "DATABASE_CLOSED");
  EXPECT_EQ(upkeep().secure().error().reason, "DATABASE_CLOSED");
  EXPECT_EQ(upkeep().copy_to(folder / "kept.db").error().reason, "DATABASE_CLOSED");
  ASSERT_TRUE(upkeep().reopen());
  EXPECT_EQ(upkeep().files(), DatabaseFiles::good) << "its own closing is no other program's";
  ASSERT_TRUE(commit(5));
  const auto report = store->audit().verify({}, {}).value();
  EXPECT_TRUE(report.intact()) << report.first.front();
}

TEST_F(UpkeepTest, AReopeningMakesNoRecordWhereTheFileWasMovedAway) {
  ASSERT_TRUE(commit(0));
  fs::rename(path, folder / "elsewhere.db");
  EXPECT_EQ(upkeep().reopen().error().reason, "DATABASE_MOVED");
  EXPECT_FALSE(fs::exists(path));
  fs::rename(folder / "elsewhere.db", path);
  ASSERT_TRUE(upkeep().reopen());
  EXPECT_TRUE(commit(1));
}

TEST_F(UpkeepTest, ACopyThatFindsNoRoomIsNotLeftBehindAndCanBeMadeLater) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  fs::rename(path, folder / "elsewhere.db");
  {
    const DiskWithoutRoom full;
    EXPECT_EQ(upkeep().copy_to(folder / "kept.db").error().reason, "DISK_FULL");
  }
  EXPECT_FALSE(fs::exists(folder / "kept.db"));
  EXPECT_FALSE(fs::exists(folder / "kept.db.part"));
  ASSERT_TRUE(upkeep().copy_to(folder / "kept.db"));
  EXPECT_EQ(open_store(folder / "kept.db", true)->points().points(run, 0, 0)->size(), 5u);
}

TEST_F(UpkeepTest, ALogThatWasCutOffIsSeen) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  fs::resize_file(path + "-wal", 4096);
  EXPECT_EQ(upkeep().files(), DatabaseFiles::log_gone);
}

TEST_F(UpkeepTest, ReopensWithALogOfItsOwn) {
  auto reader = open_store(path, true);
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  EXPECT_EQ(reader->points().points(run, 0, 0)->size(), 5u);
  fs::remove(path + "-wal");
  ASSERT_TRUE(upkeep().secure());
  reader.reset();
  ASSERT_TRUE(upkeep().reopen());
  EXPECT_EQ(upkeep().files(), DatabaseFiles::good);
  EXPECT_EQ(open_sqlite_store(path, false).error().reason, "DATABASE_IN_USE") << "the lock is kept";
  reader = open_store(path, true);
  ASSERT_TRUE(commit(5));
  EXPECT_TRUE(fs::exists(path + "-wal"));
  EXPECT_EQ(reader->points().points(run, 0, 0)->size(), 6u);
  EXPECT_EQ(points_after_a_kill(), 6u);
}

TEST_F(UpkeepTest, MovesTheLogIntoTheDatabaseAfterAWhileHoweverLittleIsInIt) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .checkpoint_every_s = 0});
  ASSERT_TRUE(commit(0));
  ASSERT_TRUE(store->idle());
  const TemporaryFolder grave;
  fs::copy_file(path, grave / "alone.db");
  EXPECT_EQ(open_store(grave / "alone.db")->points().points(run, 0, 0)->size(), 1u);
  EXPECT_EQ(SqliteOptions{}.checkpoint_every_s, 60);
}

TEST_F(UpkeepTest, StoresNothingWhileTheFileIsMovedAndContinuesWhenItIsBack) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  fs::rename(path, folder / "elsewhere.db");
  EXPECT_EQ(upkeep().files(), DatabaseFiles::moved);
  const auto refused = commit(5);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(refused.error().reason, "DATABASE_MOVED");
  EXPECT_THAT(refused.error().message, testing::HasSubstr("put the file back"));
  // What is held open is whole, wherever its file is.
  ASSERT_TRUE(upkeep().copy_to(folder / "kept.db"));
  EXPECT_EQ(open_store(folder / "kept.db", true)->points().points(run, 0, 0)->size(), 5u);
  EXPECT_EQ(upkeep().copy_to(folder / "kept.db").error().reason, "FILE_EXISTS");
  fs::rename(folder / "elsewhere.db", path);
  EXPECT_EQ(upkeep().files(), DatabaseFiles::good);
  EXPECT_TRUE(commit(5));
  EXPECT_EQ(points_after_a_kill(), 6u);
}

TEST_F(UpkeepTest, StoresNothingIntoAFileThatTookItsPlace) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  open_store(folder / "other.db").reset();
  fs::rename(folder / "other.db", path);
  EXPECT_EQ(upkeep().files(), DatabaseFiles::replaced);
  EXPECT_EQ(commit(5).error().reason, "DATABASE_REPLACED");
  ASSERT_TRUE(upkeep().copy_to(folder / "kept.db"));
  EXPECT_EQ(open_store(folder / "kept.db", true)->points().points(run, 0, 0)->size(), 5u);
}

TEST_F(UpkeepTest, SeesThatAnotherProgramWroteTheFile) {
  for (int row = 0; row < 5; ++row) ASSERT_TRUE(commit(row));
  open_store(folder / "other.db").reset();
  fs::copy_file(folder / "other.db", path, fs::copy_options::overwrite_existing);  // the same inode
  EXPECT_EQ(upkeep().files(), DatabaseFiles::overwritten);
  EXPECT_EQ(commit(5).error().reason, "DATABASE_OVERWRITTEN");
}

TEST_F(UpkeepTest, ItsOwnCheckpointsAreNoneOfThat) {
  store.reset();
  store = open_store(path, false, {.vfs = "", .checkpoint_pages = 5, .checkpoint_every_s = 0});
  const auto reader = open_store(path, true);
  for (int row = 0; row < 300; ++row) {
    ASSERT_TRUE(commit(row));
    if (row % 3 == 0) {
      ASSERT_TRUE(store->idle());
    }
    if (row % 7 == 0) {
      EXPECT_TRUE(reader->points().points(run, 0, 10));
    }
    ASSERT_EQ(upkeep().files(), DatabaseFiles::good) << "row " << row;
  }
}

TEST_F(UpkeepTest, FindsDamagedPagesTableByTable) {
  for (int row = 0; row < 200; ++row) ASSERT_TRUE(commit(row));
  store.reset();
  const std::int64_t root = root_page("point_value");
  damage(root - 1, root - 1);
  const auto checker = open_store(path, true);
  std::vector<std::string> damaged;
  const auto tables = checker->upkeep()->tables();
  ASSERT_GT(tables->size(), 20u);
  for (const auto& table : *tables) {
    const auto trouble = checker->upkeep()->check(table, {});
    ASSERT_TRUE(trouble) << trouble.error().message;
    if (!trouble->empty()) damaged.push_back(table);
  }
  EXPECT_THAT(damaged, testing::ElementsAre("point_value"));
  // The newest points are looked at first, whatever the size.
  EXPECT_NE(checker->upkeep()->check("", {}).value(), "");
}

TEST_F(UpkeepTest, ACheckGivesWayWhenItIsAskedTo) {
  for (int row = 0; row < 200; ++row) ASSERT_TRUE(commit(row));
  const auto checker = open_store(path, true);
  int asked = 0;
  const auto gave_way = checker->upkeep()->check("point_value", [&asked] { return ++asked > 0; });
  ASSERT_FALSE(gave_way);
  EXPECT_EQ(gave_way.error().reason, "GAVE_WAY");
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(checker->upkeep()->check("point_value", {}).value(), "") << "and can be made again";
}

TEST_F(UpkeepTest, KeepsHowFarTheChecksAre) {
  EXPECT_EQ(upkeep().checks()->last_clean.utc_ns, 0);
  ASSERT_TRUE(upkeep().keep_check({"point", at_s(5).utc, ""}, at_s(4).utc, false));
  ASSERT_TRUE(upkeep().keep_check({"run", at_s(6).utc, ""}, at_s(4).utc, true));
  reopen();
  auto checks = upkeep().checks();
  EXPECT_EQ(checks->begun, at_s(4).utc);
  EXPECT_EQ(checks->last_clean, at_s(6).utc);
  ASSERT_EQ(checks->tables.size(), 2u);
  ASSERT_TRUE(upkeep().keep_check({"point", at_s(9).utc, "bad page 7"}, at_s(8).utc, false));
  checks = upkeep().checks();
  EXPECT_EQ(checks->last_clean, at_s(6).utc) << "what was clean then stays said";
  EXPECT_EQ(checks->tables.front().trouble, "bad page 7");
}

TEST_F(UpkeepTest, OneDamagedModelDoesNotHideTheOthers) {
  for (int n = 1; n <= 3; ++n) {
    ModelRecord model;
    model.name = "model " + std::to_string(n);
    model.hash = "hash " + std::to_string(n);
    model.json = std::string(40'000, static_cast<char>('a' + n));  // on pages of its own
    ASSERT_TRUE(store->models().add_model(model));
  }
  ASSERT_TRUE(upkeep().secure());
  store.reset();
  // The first page of the second model's text, found by its letters: the chain of pages breaks.
  std::ifstream file(path, std::ios::binary);
  std::stringstream whole;
  whole << file.rdbuf();
  const auto text = whole.str();
  const auto at = text.find(std::string(4000, 'c'));
  ASSERT_NE(at, std::string::npos);
  damage(static_cast<std::streamoff>(at / 4096), static_cast<std::streamoff>(at / 4096));
  store = open_store(path);
  const auto models = store->models().models();
  ASSERT_TRUE(models) << models.error().message;
  ASSERT_EQ(models->size(), 3u);
  EXPECT_EQ((*models)[0].damage, "");
  EXPECT_EQ((*models)[2].damage, "");
  EXPECT_EQ((*models)[2].name, "model 3");
  EXPECT_NE((*models)[1].damage, "");
}

}  // namespace
}  // namespace driftwise::storage
