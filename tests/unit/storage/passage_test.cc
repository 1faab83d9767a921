// Rows that a run passed beside its plan: in the path of its dataset, in no count of its points.

#include "server/core/data/row_marks.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class PassageStoreTest : public StoreTest {
 protected:
  // A return to zero between two rows: motor, pose and one thermometer.
  PointRecord passage(double seconds) {
    PointRecord row;
    row.run = run;
    row.datum = datum;
    row.line = 3;
    row.zero = true;
    row.measured = at_s(seconds);
    row.dwell_s = 1.5;
    row.commanded_mm = {0};
    row.values = {{"q1_mm", 1e-5}, {"x_mm", -2e-6}, {"t01_degC", 20.52}};
    return row;
  }
  // Rows 1 and 2, with a return before the second.
  void commit_with_a_passage() {
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
    auto second = example_commit(run, datum, 2);
    second.passages = {passage(30)};
    ASSERT_TRUE(store->points().commit(second));
  }
};

TEST_F(PassageStoreTest, ARowBesideThePlanIsInThePathAndCountsAsNoPoint) {
  commit_with_a_passage();
  reopen();
  const auto record = store->runs().run(run).value();
  EXPECT_EQ(record.accepted, 2);
  EXPECT_EQ(record.attempts, 2);
  EXPECT_EQ(record.place, (Place{3, {}}));
  EXPECT_EQ(record.rows, 1008);
  const auto points = store->points().points(run, 0, 0).value();
  ASSERT_THAT(points, SizeIs(3));
  EXPECT_FALSE(points[0].passage);
  EXPECT_TRUE(points[1].passage);
  EXPECT_EQ(points[1].row, 1008) << "after the rows of the plan";
  EXPECT_TRUE(points[1].zero);
  EXPECT_EQ(points[1].line, 3);
  EXPECT_FALSE(points[2].passage);
  const auto rows = store->runs().dataset(std::vector{run}).value();
  EXPECT_THAT(rows.excluded, ElementsAre(kInUse, kPassageRow, kInUse)) << "in the order of time";
  EXPECT_THAT(rows.zero, ElementsAre(0, 1, 0));
  EXPECT_THAT(rows.find("q1")->values, ElementsAre(1 + 2.5e-5, 1e-5, 2 + 2.5e-5));
  EXPECT_THAT(store->remarks().exclusions(run).value(), IsEmpty());
}

TEST_F(PassageStoreTest, PassagesGoToDiskWithoutAPoint) {
  PointCommit alone;
  alone.run = run;
  alone.place = {5, {{3, 1}}};
  alone.passages = {passage(30), passage(40)};
  EXPECT_EQ(store->points().commit(alone).value(), std::nullopt);
  const auto record = store->runs().run(run).value();
  EXPECT_EQ(record.accepted, 0);
  EXPECT_EQ(record.attempts, 0);
  EXPECT_EQ(record.place, alone.place);
  const auto points = store->points().points(run, 0, 0).value();
  ASSERT_THAT(points, SizeIs(2));
  EXPECT_EQ(points[0].row, 1008);
  EXPECT_EQ(points[1].row, 1009);
}

TEST_F(PassageStoreTest, OfAnImportedFileItCountsAsNoPointOfTheRun) {
  Dataset file;
  file.rows = 5;
  file.excluded = {kInUse, kPassageRow, kSuspectRow, kPassageRow, kExcludedRow};
  file.columns = {{{"x", "mm"}, {1, 2, 3, 4, 5}}};
  NewRun fresh;
  fresh.name = "imported";
  fresh.rows = 5;
  fresh.created = at_s(100);
  const auto imported = store->runs().import_dataset(fresh, file).value();
  EXPECT_EQ(imported.rows, 3);
  EXPECT_EQ(imported.accepted, 3);
  std::vector<std::int64_t> rows;
  const auto points = store->points().points(imported.id, 0, 0).value();
  for (const auto& point : points) rows.push_back(point.row);
  EXPECT_THAT(rows, ElementsAre(0, 3, 1, 4, 2)) << "passages after the rows of the plan";
  const auto read = store->runs().dataset(std::vector{imported.id}).value();
  EXPECT_THAT(read.find("x")->values, ElementsAre(1, 2, 3, 4, 5)) << "in the order of the file";
  EXPECT_EQ(read.excluded, file.excluded);
}

TEST_F(PassageStoreTest, ItIsPartOfTheRecordThatTheChainProtects) {
  commit_with_a_passage();
  reopen();
  EXPECT_TRUE(store->audit().verify({}, {}).value().intact());
  store.reset();
  Database(path, SQLITE_OPEN_READWRITE, "").execute("DELETE FROM passage");
  const auto report = open_store(path, true)->audit().verify({}, {}).value();
  EXPECT_FALSE(report.intact()) << "a return that is made a reading is found";
}

TEST_F(PassageStoreTest, TheWideViewTellsThemApart) {
  commit_with_a_passage();
  Database db(path, SQLITE_OPEN_READONLY, "");
  Query query(db,
              "SELECT group_concat(is_passage) FROM (SELECT is_passage FROM point_wide ORDER BY "
              "point_id)");
  ASSERT_TRUE(query.row());
  EXPECT_EQ(query.text(0), "0,1,0");
}

TEST(LeavePassagesOut, KeepsTheRowsOfThePlan) {
  Dataset data;
  data.rows = 4;
  data.excluded = {kInUse, kPassageRow, kSuspectRow, kPassageRow};
  data.line = {1, 1, 2, 2};
  data.columns = {{{"x", "mm"}, {1, 2, 3, 4}}};
  EXPECT_THAT(leave_passages_out(data), ElementsAre(0u, 2u));
  EXPECT_EQ(data.rows, 2u);
  EXPECT_THAT(data.excluded, ElementsAre(kInUse, kSuspectRow));
  EXPECT_THAT(data.line, ElementsAre(1, 2));
  EXPECT_THAT(data.columns.front().values, ElementsAre(1, 3));
  leave_excluded_out(data);
  EXPECT_EQ(data.rows, 1u);
  EXPECT_THAT(data.excluded, IsEmpty());
}

// What a person keeps out or puts back is rows of the plan.
TEST_F(PassageStoreTest, APassageIsNeitherKeptOutNorPutBack) {
  commit_with_a_passage();
  ExclusionRecord wanted;
  wanted.run = run;
  wanted.rows = {1, 1008};
  wanted.reason = "wrong";
  wanted.at = at_s(60);
  for (const bool out : {true, false}) {
    wanted.excluded = out;
    const auto refused = store->remarks().exclude(wanted);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().reason, "NO_SUCH_ROW");
    EXPECT_THAT(refused.error().message,
                testing::AllOf(testing::HasSubstr("row 1009 of run 1 is a passage"),
                               testing::HasSubstr("a passage is in no fit"),
                               testing::HasSubstr("run points 1")));
  }
  EXPECT_THAT(store->remarks().exclusions(run).value(), IsEmpty()) << "row 2 stays in as well";
  EXPECT_THAT(store->runs().dataset(std::vector{run}).value().excluded,
              ElementsAre(kInUse, kPassageRow, kInUse));
}

}  // namespace
}  // namespace driftwise::storage
