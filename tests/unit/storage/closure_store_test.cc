// Returns to zero as they were judged, and lines that are measured again.

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

class ClosureStoreTest : public StoreTest {
 protected:
  ClosureRecord closure(ClosureDecision decision) {
    ClosureRecord record;
    record.run = run;
    record.datum = datum;
    record.line = 2;
    record.repetition = 1;
    record.measured = at_s(30);
    record.side = "q1-";
    record.by = "model 3";
    record.decision = decision;
    record.sentence = "x moved by +412 nm (limit 300): unexplained";
    record.coordinates = {{"x_mm", 412, 300, 12, 3, 2.5, 0}};
    return record;
  }
  void commit(std::int64_t row, int number = 1) {
    auto wanted = example_commit(run, datum, row);
    wanted.attempts.front().number = number;
    const auto stored = store->points().commit(wanted);
    ASSERT_TRUE(stored) << stored.error().message;
  }
};

TEST_F(ClosureStoreTest, KeepsARecordWhole) {
  auto wanted = closure(ClosureDecision::explained);
  wanted.id = store->closures().add_closure(wanted, {}).value();
  reopen();
  const auto kept = store->closures().closures(run).value();
  ASSERT_THAT(kept, SizeIs(1));
  const auto& one = kept.front();
  EXPECT_EQ(one.id, wanted.id);
  EXPECT_EQ(one.run, wanted.run);
  EXPECT_EQ(one.datum, wanted.datum);
  EXPECT_EQ(one.line, wanted.line);
  EXPECT_EQ(one.repetition, wanted.repetition);
  EXPECT_EQ(one.measured.utc, wanted.measured.utc);
  EXPECT_EQ(one.measured.monotonic_ns, wanted.measured.monotonic_ns);
  EXPECT_EQ(one.side, wanted.side);
  EXPECT_EQ(one.by, wanted.by);
  EXPECT_EQ(one.decision, wanted.decision);
  EXPECT_EQ(one.sentence, wanted.sentence);
  EXPECT_EQ(one.coordinates, wanted.coordinates);
  EXPECT_EQ(store->closures().closures(RunId{99}).error().reason, "NO_SUCH_RUN");
}

TEST_F(ClosureStoreTest, ARepeatedLineLeavesTheDatasetAndItsRowsMayHaveAPointAgain) {
  for (const std::int64_t row : {0, 1, 2, 3}) commit(row);
  ExclusionRecord mark;
  mark.run = run;
  mark.rows = {2};
  mark.reason = "an instrument was false";
  mark.at = at_s(20);
  mark.who = "daemon";
  mark.suspect = true;
  ASSERT_TRUE(store->remarks().exclude(mark));

  ASSERT_TRUE(store->closures().add_closure(closure(ClosureDecision::repeated),
                                            RepeatedLine{{2, 3}, 0, {2, {}}}));
  reopen();
  EXPECT_EQ(store->runs().dataset(std::vector{run}).value().rows, 2u);
  EXPECT_EQ(store->runs().run(run).value().accepted, 2);
  EXPECT_EQ(store->runs().run(run).value().place, (Place{2, {}}));
  EXPECT_THAT(store->closures().repeated_points(run).value(), SizeIs(2));
  EXPECT_THAT(store->points().points(run, 0, 0).value(), SizeIs(4)) << "the old points stay";

  commit(2, 2);
  EXPECT_EQ(store->points().commit(example_commit(run, datum, 2, 2)).error().code,
            ErrorCode::already_exists);
  commit(3, 2);
  const auto rows = store->runs().dataset(std::vector{run}).value();
  EXPECT_EQ(rows.rows, 4u);
  EXPECT_THAT(rows.excluded, IsEmpty()) << "the daemon's mark was on the point before";
}

TEST_F(ClosureStoreTest, ARestIsUnderWayUntilItEnds) {
  EXPECT_FALSE(store->rests().newest_rest().value());
  RestRecord rest;
  rest.begin = at_s(10).utc;
  rest.begun_by = "ada";
  rest.length_nm_per_h = 20;
  rest.temperature_k_per_h = 0.05;
  rest.window_s = 1800;
  rest.id = store->rests().begin_rest(rest).value();
  reopen();
  EXPECT_EQ(store->rests().newest_rest().value(), rest);
  ASSERT_TRUE(store->rests().end_rest(rest.id, at_s(20).utc, "ended by ada"));
  EXPECT_EQ(store->rests().newest_rest().value()->end_reason, "ended by ada");
}

}  // namespace
}  // namespace driftwise::storage
