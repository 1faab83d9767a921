// Copies of a record: checked, never over another file, and put back with their chain.

#include "storage/audit/record_copy.h"

#include <sys/stat.h>
#include <unistd.h>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::HasSubstr;

class RecordCopyTest : public StoreTest {
 protected:
  RecordCopyTest() {
    for (int row = 0; row < 5; ++row)
      EXPECT_TRUE(store->points().commit(example_commit(run, datum, row)));
  }
  std::string copy = folder / "copy.db", other = folder / "other.db";
  std::string kept_as = folder / "cell.db.before";

  static std::size_t points_in(const std::string& file) {
    return open_store(file, true)->points().points(RunId{1}, 0, 0)->size();
  }
};

TEST_F(RecordCopyTest, HoldsTheRecordAsItWasWhileMoreIsStored) {
  const auto reader = open_store(path, true);
  const auto head = store->audit().head().value();
  const auto made = reader->audit().back_up(copy, {});
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 5)));
  EXPECT_EQ(made->head, head);
  EXPECT_GT(made->rows, 250);
  EXPECT_EQ(points_in(copy), 5U);
  EXPECT_TRUE(open_store(copy, true)->audit().verify(head, {})->intact());
  EXPECT_FALSE(std::filesystem::exists(copy + ".part"));
}

TEST_F(RecordCopyTest, NeverOverwritesAndLeavesNothingOfACopyThatGaveWay) {
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  EXPECT_EQ(store->audit().back_up(copy, {}).error().reason, "FILE_EXISTS");
  const auto gave_way = store->audit().back_up(other, [] { return true; });
  // A record of a few pages is copied in the first step.
  if (!gave_way) {
    EXPECT_EQ(gave_way.error().reason, "GAVE_WAY");
    EXPECT_FALSE(std::filesystem::exists(other));
  }
  EXPECT_FALSE(std::filesystem::exists(other + ".part"));
}

// Counting the rows and checking the copy take as long as the copying: whoever ends the daemon
// waits for none of them.
TEST_F(RecordCopyTest, GivesWayInEveryStatement) {
  std::vector<Reading> readings(3000);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i].device = "scanner";
    readings[i].start = readings[i].end =
        CellTime{1'000'000'000 * static_cast<std::int64_t>(i + 1)};
    readings[i].values = {{"t01_degC", 20.0 + 1e-3 * static_cast<double>(i)}};
  }
  ASSERT_TRUE(store->readings().append(readings, {}, {}));
  int asked = 0;
  const auto never = [&asked] { return ++asked < 0; };
  ASSERT_TRUE(store->audit().back_up(copy, never));
  const int in_all = asked;
  ASSERT_GT(in_all, 6) << "the copying itself asks once for 8 MB";
  for (const int at : {1, in_all / 3, in_all / 2, in_all - 1}) {
    asked = 0;
    const auto made = store->audit().back_up(other, [&] { return ++asked >= at; });
    ASSERT_FALSE(made) << at << " of " << in_all;
    EXPECT_EQ(made.error().reason, "GAVE_WAY") << at << " of " << in_all;
    EXPECT_FALSE(std::filesystem::exists(other)) << at;
    EXPECT_FALSE(std::filesystem::exists(other + ".part")) << at;
  }
  EXPECT_TRUE(store->audit().back_up(other, {})) << "the connection is good again";
}

// A link that leads to itself stands for a folder without the right to search it: root would search
// that one all the same.
TEST_F(RecordCopyTest, IntoAFolderThatCannotBeSearchedIsRefused) {
  std::filesystem::create_symlink("loop", folder / "loop");
  const auto made = store->audit().back_up(folder / "loop/copy.db", {});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::not_found);
  EXPECT_EQ(made.error().reason, "CANNOT_OPEN");
  EXPECT_THAT(made.error().message, HasSubstr("loop/copy.db cannot be looked for"));
  ASSERT_TRUE(store->audit().back_up(copy, {})) << "another folder does";
  for (const auto& put_back : {Restore{copy, folder / "loop/cell.db", "", {}},
                               Restore{copy, folder / "loop/cell.db", kept_as, {}},
                               Restore{copy, path, folder / "loop/before.db", {}}}) {
    const auto restored = restore_record(put_back);
    ASSERT_FALSE(restored) << put_back.database;
    EXPECT_EQ(restored.error().reason, "CANNOT_OPEN") << put_back.database;
  }
}

TEST_F(RecordCopyTest, MayBeReadByWhoMayReadTheRecord) {
  const auto rights = [](const std::string& file) {
    return std::filesystem::status(file).permissions();
  };
  const auto kept = rights(path);
  for (const auto own : {std::filesystem::perms{0600}, std::filesystem::perms{0640}}) {
    std::filesystem::permissions(path, own);
    ASSERT_TRUE(store->audit().back_up(copy, {}));
    ASSERT_TRUE(store->upkeep()->copy_to(other));
    EXPECT_EQ(rights(copy), own);
    EXPECT_EQ(rights(other), own);
    std::filesystem::remove(copy);
    std::filesystem::remove(other);
  }
  std::filesystem::permissions(path, kept);
  std::filesystem::rename(path, folder / "away.db");
  ASSERT_TRUE(store->upkeep()->copy_to(other));
  EXPECT_EQ(rights(other), std::filesystem::perms{0600}) << "nobody says who might";
  std::filesystem::rename(folder / "away.db", path);
}

TEST_F(RecordCopyTest, ComesBackWhereNothingIs) {
  const auto head = store->audit().back_up(copy, {})->head;
  const auto restored = restore_record({copy, other, "", head});
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_EQ(points_in(other), 5U);
  auto back = open_store(other);  // and goes on from there
  EXPECT_TRUE(back->points().commit(example_commit(run, datum, 5)));
  EXPECT_TRUE(back->audit().verify(head, {})->intact());
}

TEST_F(RecordCopyTest, ReplacesARecordOnlyWhenAskedAndKeepsIt) {
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 5)));
  EXPECT_EQ(restore_record({copy, path, "", {}}).error().reason, "FILE_EXISTS");
  EXPECT_EQ(restore_record({copy, path, kept_as, {}}).error().reason, "DATABASE_IN_USE");
  store.reset();
  const auto restored = restore_record({copy, path, kept_as, {}});
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_EQ(points_in(path), 5U);
  EXPECT_EQ(points_in(kept_as), 6U);
}

// What a daemon left that was killed: the newest commits stand in the log alone.
class RestoreOverAKilledRecord : public RecordCopyTest {
 protected:
  RestoreOverAKilledRecord() {
    EXPECT_TRUE(store->audit().back_up(copy, {}));
    EXPECT_TRUE(store->points().commit(example_commit(run, datum, 5)));
    for (const std::string part : {"", "-wal"})
      std::filesystem::copy_file(path + part, killed + part);
  }
  std::string killed = folder / "killed.db";
};

TEST_F(RestoreOverAKilledRecord, BringsTheLogIntoTheRecordThatIsKept) {
  const auto restored = restore_record({copy, killed, kept_as, {}});
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_FALSE(std::filesystem::exists(kept_as + "-wal")) << "the record is one file";
  EXPECT_FALSE(std::filesystem::exists(killed + "-wal"));
  EXPECT_EQ(points_in(kept_as), 6U);
  EXPECT_EQ(points_in(killed), 5U);
}

TEST_F(RestoreOverAKilledRecord, ChangesNoNameBeforeTheCallerIsReady) {
  struct NotReady {};
  Restore wanted{copy, killed, kept_as, {}};
  wanted.before_names_change = [] { throw NotReady(); };
  EXPECT_THROW(restore_record(wanted), NotReady);
  EXPECT_FALSE(std::filesystem::exists(kept_as));
  EXPECT_FALSE(std::filesystem::exists(killed + ".part"));
  EXPECT_EQ(points_in(killed), 6U);
}

TEST_F(RestoreOverAKilledRecord, WaitsForAProgramThatReadsIt) {
  {
    Database reader(killed, SQLITE_OPEN_READWRITE, "");
    const Transaction view(reader, Transaction::Kind::read);
    reader.for_each_row("SELECT count(*) FROM point", [](const std::string&) {});
    const auto refused = restore_record({copy, killed, kept_as, {}});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().reason, "DATABASE_IN_USE");
    EXPECT_FALSE(std::filesystem::exists(kept_as));
  }
  EXPECT_TRUE(restore_record({copy, killed, kept_as, {}}));
}

TEST_F(RestoreOverAKilledRecord, KeepsADamagedOneWithItsLog) {
  std::ofstream(killed, std::ios::trunc) << "no database";
  ASSERT_TRUE(restore_record({copy, killed, kept_as, {}}));
  EXPECT_TRUE(std::filesystem::exists(kept_as + "-wal")) << "it may still be read by somebody";
  EXPECT_EQ(points_in(killed), 5U);
}

TEST_F(RecordCopyTest, ASecondNameThatAnInterruptedRestoreGaveGoesAtTheStart) {
  store.reset();
  const std::string second = path + ".before-20261122T093000Z", older = path + ".before-2026";
  std::filesystem::create_hard_link(path, second);
  std::filesystem::copy_file(path, older);
  EXPECT_TRUE(open_sqlite_store(path, false));
  EXPECT_FALSE(std::filesystem::exists(second));
  EXPECT_TRUE(std::filesystem::exists(older)) << "another record";
  EXPECT_EQ(points_in(path), 5U);
}

TEST_F(RecordCopyTest, OfAnotherRecordIsPutBackOnlyWhereSomebodySaysSo) {
  open_store(other).reset();
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  const auto refused = restore_record({copy, other, kept_as, {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "OTHER_RECORD");
  EXPECT_FALSE(std::filesystem::exists(kept_as));
  EXPECT_NE(identity_of_record(copy), identity_of_record(other));
  Restore wanted{copy, other, kept_as, {}};
  wanted.may_be_another = true;
  ASSERT_TRUE(restore_record(wanted));
  EXPECT_EQ(identity_of_record(other), identity_of_record(path));
}

TEST_F(RecordCopyTest, NoRecordIsMadeBesideWhatAnInterruptedRestoreLeft) {
  store.reset();
  for (const std::string left : {".before-20261122T093000Z", ".part"}) {
    std::filesystem::rename(path, path + left);
    const auto opened = open_sqlite_store(path, false);
    ASSERT_FALSE(opened) << left;
    EXPECT_EQ(opened.error().reason, "RESTORE_UNFINISHED");
    EXPECT_THAT(opened.error().message, HasSubstr(path + left));
    EXPECT_FALSE(std::filesystem::exists(path));
    std::filesystem::rename(path + left, path);
  }
  EXPECT_TRUE(open_sqlite_store(path, false)) << "a record that is there starts";
}

TEST_F(RecordCopyTest, BelongsToTheOwnerOfTheFolderAlsoWhenRootRestoresIt) {
  namespace fs = std::filesystem;
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  store.reset();
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  const bool root = ::geteuid() == 0;
  const std::string cell_folder = folder / "";
  ASSERT_TRUE(!root || ::chown(cell_folder.c_str(), 4711, 4712) == 0);
  ASSERT_TRUE(restore_record({copy, path, kept_as, {}}));
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0640U) << "as the record that it replaces";
  if (!root) GTEST_SKIP() << "owners: run as root";
  EXPECT_EQ(about.st_uid, 4711U);
  EXPECT_EQ(about.st_gid, 4712U);
}

TEST_F(RecordCopyTest, IsRefusedWhereItWasChangedOrIsOlderThanAKeptHead) {
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 5)));
  const auto later = store->audit().head().value();
  const auto older = restore_record({copy, other, "", later});
  ASSERT_FALSE(older);
  EXPECT_EQ(older.error().reason, "RECORD_CHANGED");
  Database(copy, SQLITE_OPEN_READWRITE, "").execute("UPDATE point_value SET value = 1.5");
  const auto changed = restore_record({copy, other, "", {}});
  ASSERT_FALSE(changed);
  EXPECT_THAT(changed.error().message, HasSubstr("point_value with point_id 1"));
  EXPECT_FALSE(std::filesystem::exists(other));
}

TEST_F(RecordCopyTest, OfALaterProgramIsRefused) {
  ASSERT_TRUE(store->audit().back_up(copy, {}));
  Database(copy, SQLITE_OPEN_READWRITE, "").execute("PRAGMA user_version = 99");
  EXPECT_EQ(restore_record({copy, other, "", {}}).error().reason, "SCHEMA_NEWER");
}

TEST(RecordCopy, OfAnEarlierProgramComesBack) {
  const TemporaryFolder folder;
  const auto restored =
      restore_record({copy_of_version_1_cell(folder), folder / "back.db", "", {}});
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_EQ(restored->head.entry, 0);
  EXPECT_EQ(open_store(folder / "back.db")->runs().runs(0, 0)->size(), 2U);
}

}  // namespace
}  // namespace driftwise::storage
