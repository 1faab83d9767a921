// Exclusions and notes: kept for ever, and the points as they were.

#include "storage/watch/remark_store.h"

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class RemarkStoreTest : public StoreTest {
 protected:
  RemarkStoreTest() {
    for (int row = 0; row < 6; ++row)
      EXPECT_TRUE(store->points().commit(example_commit(run, datum, row)));
  }
  Result<ExclusionRecord> exclude(std::vector<std::int64_t> rows, bool out = true,
                                  const std::string& reason = "door opened") {
    return store->remarks().exclude({.id = 0,
                                     .run = run,
                                     .excluded = out,
                                     .rows = std::move(rows),
                                     .reason = reason,
                                     .at = at_s(1000),
                                     .who = "ada",
                                     .from = "ipv4:127.0.0.1:5020"});
  }
  Dataset dataset() { return store->runs().dataset(std::vector{run}).value(); }
  NoteRecord note(NoteSubject on, const std::string& text) {
    return {.id = 0, .on = on, .text = text, .at = at_s(5), .who = "ada", .from = "p"};
  }
};

TEST_F(RemarkStoreTest, KeepRowsOutAndPutThemBackWithoutTouchingThePoints) {
  const Dataset before = dataset();
  EXPECT_TRUE(before.excluded.empty());
  ASSERT_TRUE(exclude({1, 3, 4}));
  EXPECT_THAT(dataset().excluded, ElementsAre(0, 1, 0, 1, 1, 0));
  ASSERT_TRUE(exclude({3, 4}, false, "the door was closed"));
  EXPECT_THAT(dataset().excluded, ElementsAre(0, 1, 0, 0, 0, 0));
  ASSERT_TRUE(exclude({1}, false, "nor was it open"));
  const Dataset after = dataset();
  EXPECT_TRUE(after.excluded.empty());
  EXPECT_EQ(after.find("x")->values, before.find("x")->values);

  const auto history = store->remarks().exclusions(run).value();
  ASSERT_EQ(history.size(), 3u);
  EXPECT_THAT(history[0].rows, ElementsAre(1, 3, 4));
  EXPECT_TRUE(history[0].excluded);
  EXPECT_EQ(history[0].reason, "door opened");
  EXPECT_EQ(history[0].who, "ada");
  EXPECT_EQ(history[0].from, "ipv4:127.0.0.1:5020");
  EXPECT_EQ(history[0].at.utc, at_s(1000).utc);
  EXPECT_FALSE(history[2].excluded);
}

TEST_F(RemarkStoreTest, ShowWhatTheDaemonMarkedAsSuspectUntilItIsPutBack) {
  ExclusionRecord mark{.id = 0,
                       .run = run,
                       .excluded = true,
                       .rows = {2, 3},
                       .reason = "the zero was not found again",
                       .at = at_s(1000),
                       .who = "daemon",
                       .from = "",
                       .suspect = true};
  ASSERT_TRUE(store->remarks().exclude(mark));
  ASSERT_TRUE(exclude({4}));
  EXPECT_THAT(dataset().excluded, ElementsAre(0, 0, 2, 2, 1, 0));
  EXPECT_TRUE(store->remarks().exclusions(run).value()[0].suspect);
  EXPECT_FALSE(store->remarks().exclusions(run).value()[1].suspect);
  ASSERT_TRUE(exclude({3}, false, "that point was good"));
  EXPECT_THAT(dataset().excluded, ElementsAre(0, 0, 2, 0, 1, 0));
}

TEST_F(RemarkStoreTest, KeepOnlyWhatChanges) {
  ASSERT_TRUE(exclude({1, 2}));
  EXPECT_THAT(exclude({2, 3})->rows, ElementsAre(3));
  const auto nothing = exclude({1, 2, 3});
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->id, 0);
  EXPECT_THAT(nothing->rows, IsEmpty());
  EXPECT_EQ(exclude({5}, false)->id, 0);  // was never out
  EXPECT_EQ(store->remarks().exclusions(run)->size(), 2u);
}

TEST_F(RemarkStoreTest, RefuseARowWithoutAPointAndChangeNothing) {
  const auto refused = exclude({1, 99});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NO_SUCH_ROW");
  EXPECT_THAT(refused.error().message, testing::HasSubstr("row 100"));
  EXPECT_TRUE(dataset().excluded.empty());
  EXPECT_EQ(store->remarks().exclusions(RunId{77}).error().reason, "NO_SUCH_RUN");
}

TEST_F(RemarkStoreTest, MarkTheRightRowsOfTwoRuns) {
  const RunId later = store->runs().create_run(example_run("later")).value().id;
  const DatumId second = store->points().open_datum(example_datum(later, 500)).value();
  for (int row = 0; row < 3; ++row) {
    PointCommit commit = example_commit(later, second, row);
    commit.point->measured = at_s(600 + row);
    ASSERT_TRUE(store->points().commit(commit));
  }
  ASSERT_TRUE(exclude({0}));
  const auto both = store->runs().dataset(std::vector{later, run}).value();
  EXPECT_THAT(both.excluded, ElementsAre(1, 0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_TRUE(store->runs().dataset(std::vector{later})->excluded.empty());
}

TEST_F(RemarkStoreTest, ShowAPersonWhatIsOutNow) {
  ASSERT_TRUE(exclude({1, 3}));
  ASSERT_TRUE(exclude({1}, false));
  ASSERT_TRUE(exclude({1}, true, "open after all"));
  Database db(path, SQLITE_OPEN_READONLY, "");
  Query query(db, "SELECT trajectory_row, reason, who FROM excluded_point ORDER BY 1");
  ASSERT_TRUE(query.row());
  EXPECT_EQ(query.integer(0), 1);
  EXPECT_EQ(query.text(1), "open after all");
  ASSERT_TRUE(query.row());
  EXPECT_EQ(query.integer(0), 3);
  EXPECT_EQ(query.text(1), "door opened");
  EXPECT_FALSE(query.row());
}

TEST_F(RemarkStoreTest, KeepNotesOnRunsPointsAndModels) {
  const ModelId model = store->models()
                            .add_model({.id = {},
                                        .name = "m",
                                        .json = "{}",
                                        .hash = "h",
                                        .parent = {},
                                        .created = at_s(1).utc,
                                        .created_by = "ada",
                                        .note = ""})
                            .value();
  auto& remarks = store->remarks();
  ASSERT_TRUE(remarks.add_note(note({.run = run, .row = {}, .model = {}}, "new bearings")));
  ASSERT_TRUE(remarks.add_note(note({.run = run, .row = 3, .model = {}}, "someone coughed")));
  ASSERT_TRUE(remarks.add_note(note({.run = {}, .row = {}, .model = model}, "signed")));
  const auto of_run = remarks.notes({.run = run, .row = {}, .model = {}}).value();
  ASSERT_EQ(of_run.size(), 2u);
  EXPECT_EQ(of_run[0].text, "new bearings");
  EXPECT_EQ(of_run[1].on.row, 3);
  EXPECT_EQ(of_run[1].who, "ada");
  EXPECT_EQ(remarks.notes({.run = run, .row = 3, .model = {}})->size(), 1u);
  EXPECT_THAT(*remarks.notes({.run = run, .row = 4, .model = {}}), IsEmpty());
  EXPECT_EQ(remarks.notes({.run = {}, .row = {}, .model = model})->at(0).text, "signed");
}

TEST_F(RemarkStoreTest, RefuseANoteOnNothing) {
  auto& remarks = store->remarks();
  const auto reason = [&](NoteSubject on) {
    return remarks.add_note(note(on, "t")).error().reason;
  };
  EXPECT_EQ(reason({}), "BAD_SUBJECT");
  EXPECT_EQ(reason({.run = run, .row = {}, .model = ModelId{1}}), "BAD_SUBJECT");
  EXPECT_EQ(reason({.run = RunId{77}, .row = {}, .model = {}}), "NO_SUCH_RUN");
  EXPECT_EQ(reason({.run = run, .row = 99, .model = {}}), "NO_SUCH_ROW");
  EXPECT_EQ(reason({.run = {}, .row = {}, .model = ModelId{9}}), "NO_SUCH_MODEL");
}

}  // namespace
}  // namespace driftwise::storage
