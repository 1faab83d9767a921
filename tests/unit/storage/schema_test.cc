// The schema as a person meets it, and as later versions find it.

#include "storage/schema/schema.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "storage/sqlite/failure.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using SchemaTest = StoreTest;

std::string text(const std::string& path, const char* sql) {
  Database db(path, SQLITE_OPEN_READONLY, "");
  Query query(db, sql);
  EXPECT_TRUE(query.row()) << sql;
  return query.text(0);
}

// A database as the first released program left it: the text is a file of its own and never
// changes.
TEST(Schema, OpensADatabaseOfVersion1) {
  const TemporaryFolder folder;
  const std::string path = folder / "old.db";
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/unit/storage/version_1.sql");
  ASSERT_TRUE(file);
  std::stringstream sql;
  sql << file.rdbuf();
  Database(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "").execute(sql.str());

  const auto store = open_store(path);
  const auto runs = store->runs().runs(0, 0).value();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].name, "written by version 1");
  EXPECT_EQ(runs[0].place.requeued, (std::vector<Requeued>{{1, 1}}));
  const Dataset dataset = store->runs().dataset(std::vector{runs[0].id}).value();
  EXPECT_EQ(dataset.rows, 1u);
  EXPECT_EQ(dataset.find("x")->values[0], 0.000131442);
  EXPECT_TRUE(store->points().commit(
      example_commit(runs[0].id, store->points().data(runs[0].id)->at(0).id, 2)));
}

// The way back from an upgrade.
TEST(Schema, KeepsACopyOfTheOldVersionBeforeItsFirstChange) {
  const TemporaryFolder folder;
  const std::string path = copy_of_version_1_cell(folder);
  const std::string points = text(path, "SELECT count(*) FROM point");
  std::filesystem::permissions(path, std::filesystem::perms{0600});
  { const auto store = open_store(path); }
  const std::string kept = path + ".version-1";
  EXPECT_EQ(text(kept, "PRAGMA user_version"), "1");
  EXPECT_EQ(text(kept, "PRAGMA integrity_check"), "ok");
  EXPECT_EQ(text(kept, "SELECT count(*) FROM point"), points);
  EXPECT_FALSE(std::filesystem::exists(kept + ".part"));
  EXPECT_EQ(std::filesystem::status(kept).permissions(), std::filesystem::perms{0600});
  std::filesystem::remove(kept);
  { const auto store = open_store(path); }
  EXPECT_FALSE(std::filesystem::exists(kept)) << "nothing was changed any more";
}

// What 0.1.0 left of a run on the simulated linear axis, an import, a fit and a promotion: nothing
// of it changes, and what came later works on it.
TEST(Schema, BringsACellOfVersion1UpToDate) {
  const TemporaryFolder folder;
  const std::string path = copy_of_version_1_cell(folder);
  ASSERT_EQ(text(path, "PRAGMA user_version"), "1");
  const auto count = [&](const char* sql) { return text(path, sql); };
  const std::string readings = count("SELECT count(*) || ' ' || sum(value) FROM reading_value");
  const std::string values = count("SELECT count(*) || ' ' || sum(value) FROM point_value");
  {
    const auto store = open_store(path);
    const auto runs = store->runs().runs(0, 0).value();
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_EQ(runs[1].name, "version 1 run");
    EXPECT_EQ(store->models().models()->size(), 1u);
    EXPECT_EQ(store->models().promotions()->back().model, ModelId{1});
    ExclusionRecord out{.id = 0,
                        .run = RunId{1},
                        .excluded = true,
                        .rows = {2},
                        .reason = "late",
                        .at = at_s(0),
                        .who = "ada",
                        .from = ""};
    ASSERT_TRUE(store->remarks().exclude(out));
    EXPECT_EQ(store->runs().dataset(std::vector{RunId{1}})->excluded[2], 1);
    EXPECT_TRUE(store->remarks().add_note({.id = 0,
                                           .on = {.run = {}, .row = {}, .model = ModelId{1}},
                                           .text = "carried over",
                                           .at = at_s(0),
                                           .who = "ada",
                                           .from = ""}));
  }
  EXPECT_EQ(text(path, "PRAGMA user_version"), std::to_string(schema_version()));
  EXPECT_EQ(text(path, "PRAGMA integrity_check"), "ok");
  EXPECT_EQ(count("SELECT count(*) || ' ' || sum(value) FROM reading_value"), readings);
  EXPECT_EQ(count("SELECT count(*) || ' ' || sum(value) FROM point_value"), values);
}

TEST(Schema, TakesEveryVersionInItsOwnTransaction) {
  const TemporaryFolder folder;
  Database db(folder / "a.db", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
  const std::array<std::string_view, 2> broken = {"CREATE TABLE a (v)",
                                                  "CREATE TABLE b (v); CREATE TABLE a (v)"};
  EXPECT_THROW(migrate(db, broken), StorageFailure);
  EXPECT_EQ(db.pragma("user_version"), 1);  // the first is there, nothing of the second
  const std::array<std::string_view, 2> mended = {"CREATE TABLE a (v)", "CREATE TABLE b (v)"};
  migrate(db, mended);
  EXPECT_EQ(db.pragma("user_version"), 2);
}

TEST_F(SchemaTest, ShowsTimesThatAPersonCanRead) {
  EXPECT_EQ(text(path, "SELECT created_utc FROM run"), "2026-09-21T14:13:20.000000000Z");
  EXPECT_EQ(text(path, "SELECT opened_utc FROM datum"),
            to_iso8601(at_s(1).utc).replace(19, 1, ".000000000Z"));
}

TEST_F(SchemaTest, ShowsOneColumnPerChannel) {
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  EXPECT_EQ(text(path, "SELECT t07_degC || ' ' || q1_cmd_mm FROM point_wide"), "20.57 1.0");
  EXPECT_EQ(
      text(path,
           "SELECT x_mm FROM reading_wide WHERE device = 'laser-x' ORDER BY start_ns LIMIT 1"),
      "1.0");
  PointCommit later = example_commit(run, datum, 2);
  later.point->values.push_back({"pressure_hPa", 1013.25});
  ASSERT_TRUE(store->points().commit(later));
  EXPECT_EQ(text(path, "SELECT pressure_hPa FROM point_wide WHERE trajectory_row = 2"), "1013.25");
  EXPECT_EQ(text(path, "SELECT count(*) FROM point_wide WHERE pressure_hPa IS NULL"), "1");
}

TEST_F(SchemaTest, GivesNoColumnToAChannelWhoseCommitFailed) {
  PointCommit refused = example_commit(run, DatumId{77}, 1);
  refused.point->values.push_back({"ghost_1", 1.0});
  EXPECT_FALSE(store->points().commit(refused));
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  EXPECT_EQ(text(path, "SELECT count(*) FROM channel WHERE name = 'ghost_1'"), "0");
  EXPECT_EQ(text(path, "SELECT t07_degC FROM point_wide"), "20.57");
}

TEST_F(SchemaTest, FindsReadingsByDeviceAndTimeThroughAnIndex) {
  Database db(path, SQLITE_OPEN_READONLY, "");
  Query plan(
      db,
      "EXPLAIN QUERY PLAN SELECT reading_id FROM reading WHERE device_id = 1 AND start_ns >= 2 AND "
      "start_ns < 3 ORDER BY start_ns, reading_id");
  ASSERT_TRUE(plan.row());
  EXPECT_THAT(plan.text(3),
              testing::HasSubstr("reading_time (device_id=? AND start_ns>? AND start_ns<?)"));
  EXPECT_FALSE(plan.row());  // no sorting step
}

TEST_F(SchemaTest, RefusesValuesOfTheWrongKindInAShell) {
  Database db(path, SQLITE_OPEN_READWRITE, "");
  EXPECT_THROW(db.execute("UPDATE run_progress SET state = 'rnning'"), StorageFailure);
  EXPECT_THROW(db.execute("INSERT INTO point_value VALUES (1, 2, 'soon')"), StorageFailure);
  EXPECT_THROW(db.execute("UPDATE run SET trajectory_rows = 'many'"), StorageFailure);
}

}  // namespace
}  // namespace driftwise::storage
