// Names of channels in the record: imports may use up a part of them, the cell always has its own.

#include "storage/sqlite/names.h"

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::HasSubstr;

class ChannelNamesTest : public StoreTest {
 protected:
  static Dataset file_of(int columns, const std::string& stem) {
    Dataset file;
    file.rows = 1;
    for (int i = 1; i <= columns; ++i)
      file.columns.push_back({{stem + std::to_string(i), "mm"}, {0.5}});
    return file;
  }
  Result<RunRecord> import(const Dataset& file) {
    NewRun fresh = example_run("imported");
    fresh.trajectory_text = fresh.trajectory_name = "";
    return store->runs().import_dataset(fresh, file);
  }
  int columns_of_points() {
    Database db(path, SQLITE_OPEN_READONLY, "");
    Query query(db, "SELECT * FROM point_wide");
    EXPECT_TRUE(query.row());
    return query.columns();
  }
};

TEST_F(ChannelNamesTest, OfImportsLeaveTheCellItsOwn) {
  ASSERT_TRUE(import(file_of(990, "file")));
  const auto refused = import(file_of(20, "other"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_CHANNELS");
  EXPECT_THAT(refused.error().message, HasSubstr("up to 1000 in all"));
  EXPECT_EQ(store->runs().runs(0, 0)->size(), 2U) << "nothing of it was stored";
  ASSERT_TRUE(import(file_of(6, "more"))) << "the last names";
  EXPECT_TRUE(import(file_of(990, "file"))) << "names that are on record";
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0))) << "nine new ones of the cell";
  EXPECT_EQ(import(file_of(1, "last")).error().reason, "TOO_MANY_CHANNELS");
}

// SQLite refuses a view of more than 2000 columns with every statement on it.
TEST_F(ChannelNamesTest, BeyondAViewsColumnsStayInTheNarrowTables) {
  ASSERT_TRUE(import(file_of(990, "file")));
  PointCommit commit = example_commit(run, datum, 0);
  for (int i = 1; i <= 1100; ++i)
    commit.point->values.push_back({"cell" + std::to_string(i) + "_mm", 0.25});
  ASSERT_TRUE(store->points().commit(commit));
  EXPECT_EQ(columns_of_points(), 1911);
  const auto points = store->points().points(run, 0, 0).value();
  EXPECT_EQ(points.front().values.size(), commit.point->values.size());
}

}  // namespace
}  // namespace driftwise::storage
