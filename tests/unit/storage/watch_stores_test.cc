// The record by cursor, alarms, kept trajectories.

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class WatchStoresTest : public StoreTest {
 protected:
  void event(const std::string& what) {
    ASSERT_TRUE(store->events().add_event({{}, at_s(1), "ada", "", what, "detail", {}}));
  }
  void point(std::int64_t row) {
    PointCommit commit;
    commit.run = run;
    AttemptRecord attempt;
    attempt.row = row;
    commit.attempts.push_back(attempt);
    PointRecord accepted;
    accepted.run = run;
    accepted.datum = datum;
    accepted.row = row;
    accepted.values = {{"q1_mm", 0.1}};
    commit.point = accepted;
    ASSERT_TRUE(store->points().commit(commit));
  }
};

TEST_F(WatchStoresTest, PagesHoldEveryRecordOnceWhateverTheirSize) {
  for (int i = 0; i < 23; ++i) {
    event("number " + std::to_string(i));
    if (i % 2 == 0) point(i);
    if (i % 5 == 0) {
      ASSERT_TRUE(store->alarms().raise(
          {{}, AlarmLevel::warning, "k", std::to_string(i), "m", at_s(i).utc, {}, {}, "", {}, 0}));
    }
  }
  const auto newest = store->records().newest().value();
  for (const int limit : {1, 3, 7, 1000}) {
    RecordCursor at;
    std::vector<std::string> events;
    std::vector<std::int64_t> points, attempts, alarms;
    for (int pages = 0; at != newest; ++pages) {
      ASSERT_LT(pages, 100);
      const auto page = store->records().records(at, newest, limit).value();
      for (const auto& one : page.events) events.push_back(one.what);
      for (const auto& one : page.points) points.push_back(one.row);
      for (const auto& one : page.attempts) attempts.push_back(one.attempt.row);
      for (const auto& one : page.alarms) alarms.push_back(one.id.value);
      ASSERT_NE(page.to, at);
      at = page.to;
    }
    EXPECT_EQ(events.size(), 23U);
    EXPECT_EQ(events.back(), "number 22");
    EXPECT_EQ(points.size(), 12U);
    EXPECT_EQ(attempts, points);
    EXPECT_EQ(alarms.size(), 5U);
  }
}

TEST_F(WatchStoresTest, APageStopsWhereItWasTold) {
  event("one");
  const auto then = store->records().newest().value();
  event("two");
  const auto page = store->records().records({}, then, 100).value();
  ASSERT_EQ(page.events.size(), 1U);
  EXPECT_EQ(page.to, then);
}

TEST_F(WatchStoresTest, EachDatabaseHasANameThatStays) {
  const auto name = store->records().database_id().value();
  EXPECT_EQ(name.size(), 16U);
  reopen();
  EXPECT_EQ(store->records().database_id().value(), name);
}

TEST_F(WatchStoresTest, AnAlarmKeepsItsSentenceAndItsConsequencesApart) {
  const auto raised = store->alarms()
                          .raise({{},
                                  AlarmLevel::failed,
                                  "device.lost",
                                  "laser-x",
                                  "gone",
                                  at_s(1).utc,
                                  {},
                                  {},
                                  "",
                                  {"run 3 waits"},
                                  0})
                          .value();
  EXPECT_EQ(raised.message, "gone");
  EXPECT_EQ(raised.consequences, std::vector<std::string>{"run 3 waits"});
  const std::vector<std::string> more = {"run 3 waits", "a name\nwith a line feed"};
  const auto told = store->alarms().tell(raised.id, "gone for 9 s", more).value();
  EXPECT_GT(told.change, raised.change);
  reopen();
  const auto standing = store->alarms().alarms(false, 10).value();
  ASSERT_EQ(standing.size(), 1U);
  EXPECT_EQ(standing[0].message, "gone for 9 s");
  ASSERT_EQ(standing[0].consequences.size(), 2U);
  EXPECT_EQ(standing[0].consequences[1], "a name with a line feed");
  EXPECT_EQ(store->alarms().tell({77}, "m", {}).error().reason, "NO_SUCH_ALARM");
}

TEST_F(WatchStoresTest, AnAlarmIsOverOnlyWhenItIsClearedAndAcknowledged) {
  const auto raise = [&](const std::string& subject) {
    return store->alarms()
        .raise(
            {{}, AlarmLevel::failed, "device.lost", subject, "m", at_s(1).utc, {}, {}, "", {}, 0})
        .value();
  };
  const auto first = raise("laser-x"), second = raise("laser-x");
  EXPECT_NE(first.id, second.id);
  ASSERT_TRUE(store->alarms().acknowledge(first.id, at_s(2).utc, "ada"));
  reopen();
  EXPECT_EQ(store->alarms().alarms(false, 10)->size(), 2U);  // the first still holds
  const auto cleared = store->alarms().clear(first.id, at_s(3).utc).value();
  EXPECT_EQ(cleared.acknowledged_by, "ada");
  EXPECT_GT(cleared.change, second.change);
  const auto standing = store->alarms().alarms(false, 10).value();
  ASSERT_EQ(standing.size(), 1U);
  EXPECT_EQ(standing[0].id, second.id);
  EXPECT_EQ(standing[0].acknowledged.utc_ns, 0);  // one acknowledgement is for one alarm
  EXPECT_EQ(store->alarms().alarms(true, 10)->size(), 2U);
  const auto again = store->alarms().acknowledge(first.id, at_s(9).utc, "bob").value();
  EXPECT_EQ(again.acknowledged_by, "ada");
  EXPECT_EQ(store->alarms().clear({99}, at_s(3).utc).error().reason, "NO_SUCH_ALARM");
}

TEST_F(WatchStoresTest, ATrajectoryOnceKeptNeverChanges) {
  KeptTrajectory wanted{{}, "grid", "q1_mm\n0\n", "h1", 1, at_s(1).utc, "ada"};
  const auto kept = store->trajectories().keep(wanted).value();
  wanted.name = "another name";
  EXPECT_EQ(store->trajectories().keep(wanted)->name, "grid");
  wanted.hash = "h2";  // as a later program names the same text
  EXPECT_EQ(store->trajectories().keep(wanted)->id, kept.id);
  wanted.text = "q1_mm\n1\n";
  EXPECT_NE(store->trajectories().keep(wanted)->id, kept.id);
  const auto all = store->trajectories().trajectories().value();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, "another name");  // newest first
  EXPECT_EQ(all[0].text, "");
  EXPECT_EQ(store->trajectories().trajectory(kept.id)->text, "q1_mm\n0\n");
  EXPECT_EQ(store->trajectories().trajectory({9}).error().reason, "NO_SUCH_TRAJECTORY");
}

}  // namespace
}  // namespace driftwise::storage
