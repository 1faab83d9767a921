#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using RunStoreTest = StoreTest;

TEST_F(RunStoreTest, KeepsEverythingThatACommitBrings) {
  const PointCommit commit = example_commit(run, datum, 0);
  const auto id = store->points().commit(commit).value();
  ASSERT_TRUE(id.has_value());
  reopen();

  const auto points = store->points().points(run, 0, 0).value();
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].id, *id);
  EXPECT_EQ(points[0].row, 0);
  EXPECT_EQ(points[0].datum, datum);
  EXPECT_TRUE(points[0].zero);
  EXPECT_EQ(points[0].measured.utc, commit.point->measured.utc);
  EXPECT_EQ(points[0].measured.monotonic_ns, commit.point->measured.monotonic_ns);
  EXPECT_EQ(points[0].dwell_s, 2.2);
  EXPECT_THAT(points[0].commanded_mm, testing::ElementsAre(0.0));
  ASSERT_EQ(points[0].values.size(), commit.point->values.size());
  for (const auto& value : commit.point->values)
    EXPECT_EQ(value_of(points[0].values, value.channel), value.value);

  const auto attempts = store->points().attempts(run).value();
  ASSERT_EQ(attempts.size(), 1u);
  EXPECT_EQ(attempts[0].verdict, Verdict::accepted);
  EXPECT_EQ(attempts[0].spread_nm, 2.5);
  EXPECT_EQ(attempts[0].ended.utc, commit.attempts[0].ended.utc);

  EXPECT_EQ(store->readings().readings("laser-x", {0}, at_s(1e6).utc, 0).value().size(), 4u);
  EXPECT_EQ(
      store->readings().readings("scanner", {0}, at_s(1e6).utc, 0).value().at(0).values.size(), 9u);
  const auto moves = store->readings().moves({0}, at_s(1e6).utc).value();
  ASSERT_EQ(moves.size(), 1u);
  EXPECT_EQ(moves[0].run, run);
  EXPECT_EQ(moves[0].cause, "point");

  const RunRecord record = store->runs().run(run).value();
  EXPECT_EQ(record.accepted, 1);
  EXPECT_EQ(record.attempts, 1);
  EXPECT_EQ(record.place.next_row, 1);
}

TEST_F(RunStoreTest, RefusesTheSameCommitTwiceAndDoublesNothing) {
  const PointCommit commit = example_commit(run, datum, 3);
  ASSERT_TRUE(store->points().commit(commit));
  const auto again = store->points().commit(commit);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::already_exists);
  EXPECT_EQ(again.error().reason, "ALREADY_STORED");
  EXPECT_EQ(store->points().points(run, 0, 0).value().size(), 1u);
  EXPECT_EQ(store->runs().run(run).value().accepted, 1);
  EXPECT_EQ(store->readings().readings("", {0}, at_s(1e6).utc, 0).value().size(), 9u);
  EXPECT_EQ(store->readings().moves({0}, at_s(1e6).utc).value().size(), 1u);
}

TEST_F(RunStoreTest, RefusesASecondPointOfOneRowEvenAsAnotherAttempt) {
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 3)));
  PointCommit other = example_commit(run, datum, 3);
  other.attempts[0].number = 2;
  EXPECT_EQ(store->points().commit(other).error().code, ErrorCode::already_exists);
  EXPECT_EQ(store->points().attempts(run).value().size(), 1u);
}

TEST_F(RunStoreTest, CountsWhatWasGivenUpAndRemembersWhatIsQueuedAgain) {
  PointCommit requeued = example_commit(run, datum, 5);
  requeued.attempts[0].verdict = Verdict::requeued;
  requeued.attempts[0].reason = "spread 7.3 nm of 4 readings, limit 5 nm";
  requeued.point.reset();
  requeued.place = {.next_row = 6, .requeued = {{.row = 5, .count = 1}, {.row = 2, .count = 2}}};
  EXPECT_EQ(store->points().commit(requeued).value(), std::nullopt);
  PointCommit given_up = requeued;
  given_up.attempts[0].number = 2;
  given_up.attempts[0].verdict = Verdict::given_up;
  given_up.place.requeued.pop_back();
  ASSERT_TRUE(store->points().commit(given_up));
  reopen();

  const RunRecord record = store->runs().run(run).value();
  EXPECT_EQ(record.place, given_up.place);
  EXPECT_EQ(record.given_up, 1);
  EXPECT_EQ(record.attempts, 2);
  EXPECT_EQ(record.accepted, 0);
  EXPECT_EQ(store->points().attempts(run).value().at(0).reason, requeued.attempts[0].reason);
}

TEST_F(RunStoreTest, ACommitForARunThatIsNotThereLeavesNothing) {
  const auto result = store->points().commit(example_commit(RunId{99}, datum, 0));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::not_found);
  EXPECT_TRUE(store->readings().readings("", {0}, at_s(1e6).utc, 0).value().empty());
  // The channels were new in the commit that failed: the next one must not rely on their numbers.
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0)));
  EXPECT_EQ(store->points().points(run, 0, 0).value().at(0).values.size(), 12u);
}

TEST_F(RunStoreTest, ACommitForADatumThatIsNotThereIsRefused) {
  const auto result = store->points().commit(example_commit(run, DatumId{77}, 0));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, "NO_SUCH_RECORD");
}

TEST_F(RunStoreTest, AnswersTheSameRequestWithTheFirstRun) {
  NewRun wanted = example_run("weekend");
  wanted.request_id = "r-1";
  const RunId first = store->runs().create_run(wanted).value().id;
  EXPECT_EQ(store->runs().create_run(wanted).value().id, first);
  wanted.trajectory_text += "2\n";
  const auto other = store->runs().create_run(wanted);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().reason, "REQUEST_ID_REUSED");
  EXPECT_EQ(store->runs().runs(0, 0).value().size(), 2u);
}

TEST_F(RunStoreTest, ListsRunsNewestFirstByPages) {
  const RunId second = store->runs().create_run(example_run("second")).value().id;
  const RunId third = store->runs().create_run(example_run("third")).value().id;
  const auto page = store->runs().runs(2, 0).value();
  ASSERT_EQ(page.size(), 2u);
  EXPECT_EQ(page[0].id, third);
  EXPECT_EQ(page[1].id, second);
  EXPECT_EQ(page[1].trajectory_text, "") << "a list of grids would have hundreds of megabytes";
  EXPECT_EQ(store->runs().run(second)->trajectory_text, example_run().trajectory_text);
  EXPECT_EQ(page[1].rows, example_run().rows);
  EXPECT_EQ(store->runs().runs(2, page[1].id.value).value().at(0).id, run);
}

TEST_F(RunStoreTest, FindsTheRunToGoOnWith) {
  EXPECT_EQ(store->runs().unfinished_run().value()->id, run);
  RunChange change;
  change.state = RunState::done;
  change.ended = at_s(100).utc;
  change.max_lag_s = 0.25;
  ASSERT_TRUE(store->runs().change_run(run, change));
  EXPECT_EQ(store->runs().unfinished_run().value(), std::nullopt);
  const RunRecord record = store->runs().run(run).value();
  EXPECT_EQ(record.state, RunState::done);
  EXPECT_EQ(record.started, at_s(0.5).utc);  // what is not set stays
  EXPECT_EQ(record.max_lag_s, 0.25);
  EXPECT_EQ(store->runs().change_run(RunId{99}, change).error().reason, "NO_SUCH_RUN");
}

TEST_F(RunStoreTest, KeepsTheDatumWithItsTemperaturesAndTheMissingOnes) {
  const auto datums = store->points().data(run).value();
  ASSERT_EQ(datums.size(), 1u);
  EXPECT_EQ(datums[0].id, datum);
  EXPECT_EQ(datums[0].reason, "start");
  EXPECT_EQ(value_of(datums[0].values, "t01_degC"), 20.503);
  EXPECT_TRUE(is_missing(value_of(datums[0].values, "t02_degC")));
}

TEST_F(RunStoreTest, PagesThroughPoints) {
  for (int row = 0; row < 5; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  const auto first = store->points().points(run, 0, 3).value();
  ASSERT_EQ(first.size(), 3u);
  const auto rest = store->points().points(run, first.back().id.value, 3).value();
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(rest.back().row, 4);
}

TEST_F(RunStoreTest, RefusesAChannelWithoutUnit) {
  PointCommit commit = example_commit(run, datum, 0);
  commit.point->values.push_back({"pressure", 1013.0});
  const auto result = store->points().commit(commit);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, "BAD_CHANNEL");
  EXPECT_EQ(store->runs().run(run).value().accepted, 0);
}

StopRecord stop_at_s(double seconds) {
  return {{}, "axis", "bob", "peer",           "stopped by bob", at_s(seconds),
          1,  {},     "bob", at_s(seconds).utc};
}

TEST_F(RunStoreTest, AStopPausesTheNewestRunThatIsQueuedAndNoOlderOne) {
  const auto never_begun = store->runs().create_run(example_run("B")).value().id;
  const auto about_to_begin = store->runs().create_run(example_run("C")).value().id;
  ASSERT_TRUE(store->stops().keep(std::vector{stop_at_s(5)}));
  EXPECT_EQ(store->runs().run(never_begun)->state, RunState::queued);
  EXPECT_EQ(store->runs().run(about_to_begin)->state, RunState::paused);
  EXPECT_EQ(store->runs().run(about_to_begin)->reason, "stopped by bob");
  // The hold that a resume must name.
  EXPECT_EQ(store->runs().run(about_to_begin)->hold,
            (RunHold{RunHold::Kind::stop, "bob", at_s(5).utc, "stopped by bob"}));
}

TEST_F(RunStoreTest, ARunIsCreatedPausedWhenAStopCameAfterItWasAskedFor) {
  ASSERT_TRUE(store->stops().keep(std::vector{stop_at_s(5)}));
  ASSERT_TRUE(store->stops().confirm(stop_at_s(5), at_s(6).utc));
  auto before = example_run("asked for before the stop");
  before.created = at_s(4);
  const auto paused = store->runs().create_run(before).value();
  EXPECT_EQ(paused.state, RunState::paused);
  EXPECT_EQ(paused.reason, "stopped by bob");
  auto after = example_run("asked for after the stop");
  after.created = at_s(7);
  EXPECT_EQ(store->runs().create_run(after)->state, RunState::queued);
}

TEST_F(RunStoreTest, TheNewestDatumIsTheLastThatWasOpenedHere) {
  EXPECT_EQ(store->points().newest_datum().value()->id, datum);
  const auto by_hand =
      store->points().open_datum({{}, std::nullopt, at_s(900), "homed by ada", {{"x_mm", 0.25}}});
  ASSERT_TRUE(by_hand);
  const auto newest = store->points().newest_datum().value();
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->id, *by_hand);
  EXPECT_FALSE(newest->run);
  EXPECT_EQ(newest->opened.utc, at_s(900).utc);
  EXPECT_EQ(value_of(newest->values, "x_mm"), 0.25);
}

}  // namespace
}  // namespace driftwise::storage
