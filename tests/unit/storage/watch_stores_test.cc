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

TEST_F(WatchStoresTest, AnAlarmThatHoldsStandsInTheListHoweverManyNewerOnesAreOver) {
  const auto raise = [&](const std::string& kind, CellTime cleared) {
    AlarmRecord alarm;
    alarm.kind = kind;
    alarm.subject = "s";
    alarm.message = "m";
    alarm.since = at_s(1).utc;
    alarm.cleared = cleared;
    return store->alarms().raise(alarm).value().id;
  };
  const auto holds = raise("device.lost", {});
  std::vector<AlarmId> over;
  for (int i = 0; i < 5; ++i) over.push_back(raise("run.failed", at_s(1).utc));
  const auto ids = [&](bool with_history, int limit) {
    std::vector<AlarmId> found;
    const auto alarms = store->alarms().alarms(with_history, limit).value();
    for (const auto& alarm : alarms) found.push_back(alarm.id);
    return found;
  };
  EXPECT_EQ(ids(false, 3), (std::vector{over[4], over[3], holds})) << "newest first";
  EXPECT_EQ(ids(false, 1), std::vector{holds});
  EXPECT_EQ(ids(true, 3), (std::vector{over[4], over[3], over[2]})) << "the newest of all";
}

TEST_F(WatchStoresTest, AShelfHoldsForTheConditionUntilItsTimeIsOver) {
  const auto raise = [&](const std::string& subject) {
    AlarmRecord alarm;
    alarm.level = AlarmLevel::failed;
    alarm.kind = "device.lost";
    alarm.subject = subject;
    alarm.message = "m";
    alarm.since = at_s(1).utc;
    return store->alarms().raise(alarm).value();
  };
  const auto first = raise("laser-x");
  const auto other = raise("laser-y");
  const auto shelved =
      store->alarms().shelve(first.id, {at_s(2).utc, at_s(100).utc, "ada", "aligned\nnow"}).value();
  EXPECT_EQ(shelved.state(), AlarmState::shelved);
  EXPECT_EQ(shelved.shelve_reason, "aligned now");
  EXPECT_GT(shelved.change, other.change);  // whoever watches hears of it
  ASSERT_TRUE(store->alarms().clear(first.id, at_s(3).utc));
  reopen();
  EXPECT_EQ(raise("laser-x").state(), AlarmState::shelved);  // the condition returned
  EXPECT_EQ(raise("laser-y").state(), AlarmState::unacknowledged);
  EXPECT_TRUE(store->alarms().end_shelves(at_s(99).utc)->empty());
  const auto back = store->alarms().end_shelves(at_s(100).utc).value();
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].state(), AlarmState::returned_unacknowledged);
  EXPECT_EQ(back[1].state(), AlarmState::unacknowledged);
  ASSERT_TRUE(store->alarms().shelve(first.id, {at_s(101).utc, at_s(200).utc, "ada", "again"}));
  EXPECT_EQ(store->alarms().unshelve(first.id, at_s(102).utc)->shelved_until.utc_ns, 0);
  EXPECT_EQ(store->alarms().shelve({99}, {}).error().reason, "NO_SUCH_ALARM");
}

TEST_F(WatchStoresTest, AnAlarmWithoutATellingIsStillToBeTold) {
  AlarmRecord alarm;
  alarm.kind = "device.lost";
  alarm.since = at_s(1).utc;
  const auto stands = store->alarms().raise(alarm).value();
  alarm.cleared = at_s(5).utc;
  const auto over = store->alarms().raise(alarm).value();
  const std::vector<std::string> names = {"duty", "mail"};
  const auto open = store->outbox().open(names, at_s(6).utc, at_s(4).utc).value();
  ASSERT_EQ(open.alarms.size(), 2U);
  EXPECT_TRUE(open.tellings.empty());
  ASSERT_EQ(open.receivers.size(), 2U);
  EXPECT_EQ(open.receivers[0].known_since, at_s(6).utc);
  TellingRecord told;
  told.alarm = stands.id;
  told.receiver = "duty";
  told.firing = told.last = at_s(7).utc;
  told.count = 1;
  ASSERT_TRUE(store->outbox().put(std::vector{told}));
  told.failed = 2;
  told.error = "HTTP 500";
  ASSERT_TRUE(store->outbox().put(std::vector{told}));  // in place of the other
  reopen();
  const auto later = store->outbox().open(names, at_s(9).utc, at_s(8).utc).value();
  ASSERT_EQ(later.alarms.size(), 1U);  // the other one was over before
  EXPECT_EQ(later.alarms[0].id, stands.id);
  ASSERT_EQ(later.tellings.size(), 1U);
  EXPECT_EQ(later.tellings[0].firing, at_s(7).utc);
  EXPECT_EQ(later.tellings[0].error, "HTTP 500");
  EXPECT_EQ(later.receivers[0].known_since, at_s(6).utc);
  EXPECT_EQ(store->outbox().tellings(10)->size(), 1U);
  EXPECT_NE(over.id, stands.id);
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
