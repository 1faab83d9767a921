// The queue on virtual time: order, holds, failures, what follows, and kill -9.

#include "server/application/queue/queue.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <set>

#include "server/application/plumbing/crash_point.h"
#include "tests/unit/application/queue/queue_cell.h"
#include "tests/unit/application/shared_world.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

TEST_F(QueueTest, MakesARunOfEachEntryInTurn) {
  auto first = draft("a");
  first.metadata = {{"sample", "A12"}};
  const auto a = add(first), b = add(draft("b"));
  until(a, QueueState::running);
  EXPECT_EQ(waits_for(b), "waits until entry 1 'a' is over");
  until(b, QueueState::done);
  EXPECT_EQ(names_of_runs(), (std::vector<std::string>{"a", "b"}));
  const auto run = *cell.await(cell.run(*look(a).run));
  EXPECT_EQ(run.state, RunState::done);
  EXPECT_EQ(run.operator_name, "ada");
  EXPECT_EQ(run.queue_entry, a.entry.id);
  EXPECT_EQ(metadata_text(run.metadata), "sample=A12");
  EXPECT_TRUE(look(b).accepted());
  EXPECT_EQ(cell.events_named("queue.done").front(),
            "entry 1 'a' is done: run 1, 3 of 3 rows accepted");
}

TEST_F(QueueTest, ListsTheNewestThatAreOver) {
  ASSERT_TRUE(cell.await(cell->queue.hold(cell.ada, "")));  // none begins
  for (int i = 0; i < 210; ++i) {
    const auto line = add(draft("night"));
    ASSERT_TRUE(cell.await(cell->queue.remove(cell.ada, line.entry.id, "")));
  }
  const auto listed = cell->queue.list().lines;
  ASSERT_EQ(listed.size(), 200U);
  EXPECT_EQ(listed.front().entry.id.value, 210);
  EXPECT_EQ(listed.back().entry.id.value, 11);
}

TEST_F(QueueTest, AnnouncesOnlyARunThatNobodyAskedForJustNow) {
  add(draft("a"));
  const auto b = add(draft("b"));
  until(b, QueueState::done);
  const auto announced = cell.events_named("run.moves_soon");
  ASSERT_EQ(announced.size(), 1u);
  EXPECT_THAT(announced.front(),
              HasSubstr("the queue begins entry 2 'b'; a stop or a pause keeps it from"));
  // It was planned: nobody is woken.
  EXPECT_TRUE(cell.alarms_of("run.moves_soon").empty());
}

TEST_F(QueueTest, AnnouncesInUtcAlsoAfterTheWallClockWasSet) {
  cell.time().wall_clock_set += std::chrono::hours(2);
  cell.pass(60);
  add(draft("a"));
  until(add(draft("b")), QueueState::done);
  const std::string announced = cell.events_named("run.moves_soon").at(0);
  const auto begin = announced.find(" at ") + 4;
  const auto stated = parse_iso8601(announced.substr(begin, announced.find(": ", begin) - begin));
  ASSERT_TRUE(stated) << announced;
  const double ago_s = 1e-9 * static_cast<double>(cell->host.utc(cell.now()).ns - stated->utc_ns);
  EXPECT_GT(ago_s, 0);
  EXPECT_LT(ago_s, 3600) << announced;
}

TEST_F(QueueTest, TakesTheHigherPriorityFirstAndCanBeReordered) {
  ASSERT_TRUE(cell.await(cell->queue.hold(cell.ada, "all at once")));
  const auto a = add(draft("a")), b = add(draft("b")), c = add(draft("c"));
  application::QueueEdit urgent;
  urgent.priority = 7;
  ASSERT_TRUE(cell.await(cell->queue.change(cell.ada, c.entry.id, urgent)));
  ASSERT_TRUE(cell.await(cell->queue.move(cell.ada, b.entry.id, a.entry.id)));
  EXPECT_EQ(waits_for(a),
            "waits for a release of the queue, which is held: held by ada: all at once");
  release();
  until(a, QueueState::done);
  EXPECT_EQ(names_of_runs(), (std::vector<std::string>{"c", "b", "a"}));
}

TEST_F(QueueTest, WaitsForALeaseOfSomebodyElse) {
  const auto token = cell.lease();
  const auto a = add(draft("a"));
  cell.pass(60);
  EXPECT_EQ(state_of(a), QueueState::waiting);
  EXPECT_THAT(waits_for(a), HasSubstr("waits: ada holds the lease to move until"));
  give_up_lease(token);
  until(a, QueueState::done);
}

TEST_F(QueueTest, WaitsForItsTimeAndForTheEntryBefore) {
  auto late = draft("late");
  late.not_before = UtcTime{cell.now().utc_ns + 3'600'000'000'000};
  const auto a = add(late);
  auto next = draft("next");
  next.after = a.entry.id;
  const auto b = add(next);
  cell.pass(3000);
  EXPECT_EQ(waits_for(a), "waits until 2026-11-21T09:00:00Z");
  EXPECT_EQ(waits_for(b), "waits until entry 1 'late' is accepted: that one waits");
  until(b, QueueState::done);
  EXPECT_GE(look(a).begun.utc_ns, late.not_before.ns);
  EXPECT_GE(look(b).begun, look(a).ended);
}

TEST_F(QueueTest, WaitsForACondition) {
  world.warming_k_per_h = 1;  // t01 begins at 20.1 degC
  auto warm = draft("warm");
  warm.condition = "t01 > 20.6 degC for 10 min";
  const auto a = add(warm);
  EXPECT_EQ(a.entry.condition, "t01_degC > 20.6 degC for 10 min");
  cell.pass(60);
  EXPECT_THAT(waits_for(a), HasSubstr("waits for t01_degC above 20.6 degC for 10 min: 20.1"));
  until(a, QueueState::running);
  const double hours = static_cast<double>(look(a).begun.utc_ns - kWorldBegin.utc_ns) / 3.6e12;
  EXPECT_GT(hours, 0.5 + 10.0 / 60);  // warm enough after half an hour, and 10 min on top
  EXPECT_LT(hours, 0.5 + 13.0 / 60);  // buckets of a minute, looks of five seconds
}

TEST_F(QueueTest, AFailedEntryIsBackInFrontAndHoldsTheQueue) {
  auto broken = draft("broken");
  broken.compensate = true;
  broken.trajectory_text = "x_mm\n0\n1\n0\n";  // no model serves when it starts
  const auto a = add(broken), b = add(draft("b"));
  cell.until([&] { return hold().held; });
  EXPECT_EQ(state_of(a), QueueState::waiting);
  EXPECT_THAT(look(a).reason, HasSubstr("no model serves"));
  EXPECT_THAT(hold().why, HasSubstr("entry 1 'broken': no model serves"));
  cell.pass(60);
  EXPECT_EQ(state_of(b), QueueState::waiting);
  ASSERT_EQ(cell.alarms_of("queue.failed").size(), 1u) << "while the queue waits for a person";
  EXPECT_THAT(cell.alarms_of("queue.failed").front(), HasSubstr("entry 1 'broken': no model"));
  EXPECT_TRUE(cell.alarms_of("queue.held").empty()) << "one alarm for one cause";
  EXPECT_EQ(cell.events_named("queue.failed").size(), 1u);
  ASSERT_TRUE(cell.await(cell->queue.remove(cell.ada, a.entry.id, "")));
  release();
  until(b, QueueState::done);
}

TEST_F(QueueTest, AnEntryThatIsSetAsideLetsTheNextOneStartAndCanComeBack) {
  auto broken = draft("broken");
  broken.compensate = true;
  broken.trajectory_text = "x_mm\n0\n1\n0\n";
  broken.on_failure = OnFailure::set_aside;
  const auto a = add(broken), b = add(draft("b"));
  until(b, QueueState::done);
  EXPECT_EQ(state_of(a), QueueState::set_aside);
  EXPECT_THAT(look(a).reason, HasSubstr("no model serves"));
  EXPECT_FALSE(hold().held);
  const auto back = cell.await(cell->queue.move(cell.ada, a.entry.id, std::nullopt));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->entry.state, QueueState::waiting);
}

TEST_F(QueueTest, AnEntryThatIsSetAsideLeavesItsRepetitionToTheNextOne) {
  auto broken = draft("broken");
  broken.compensate = true;
  broken.trajectory_text = "x_mm\n0\n1\n0\n";
  broken.on_failure = OnFailure::set_aside;
  broken.repeat_every_s = 7200;
  const auto a = add(broken);
  const auto repeats = [&] {
    const auto lines = cell->queue.list().lines;
    return std::ranges::count_if(lines, [](const auto& line) {
      return line.entry.state == QueueState::waiting && line.entry.repeat_every_s == 7200;
    });
  };
  until(a, QueueState::set_aside);
  EXPECT_EQ(repeats(), 1);
  ASSERT_TRUE(cell.await(cell->queue.move(cell.ada, a.entry.id, QueueEntryId{0})));
  EXPECT_EQ(state_of(a), QueueState::waiting);
  until(a, QueueState::set_aside);
  EXPECT_EQ(repeats(), 1) << "one series, however often it was moved back";
}

// The campaign is about to begin when the daemon is asked to end.
TEST_F(QueueTest, ACampaignThatIsBeginningKeepsNoDaemonAlive) {
  ASSERT_TRUE(cell.await(cell->queue.hold(cell.ada, "all at once")));
  add(draft("a"));
  release();
  cell.shut_down();
  EXPECT_EQ(world.moves, 0);
  auto store = *kSqlite(folder / "cell.sqlite", true);
  const auto runs = *store->runs().runs(0, 0);
  for (const auto& run : runs) EXPECT_FALSE(is_over(run.state));
}

TEST_F(QueueTest, APersonsStopHoldsItUntilAPersonReleasesIt) {
  const auto a = add(draft("a")), b = add(draft("b"));
  cell.until([&] { return cell.status().run && cell.status().run->run.accepted > 0; });
  ASSERT_TRUE(cell.await(cell->manual.stop_all(cell.ada)));
  EXPECT_TRUE(hold().held);
  EXPECT_EQ(hold().who, "ada");
  cell.pass(5);
  const auto alarms = cell.await(cell->alarms.list(true, 100));
  const auto told = std::ranges::find(*alarms, "queue.held", &AlarmRecord::kind);
  ASSERT_NE(told, alarms->end());
  EXPECT_THAT(told->message, HasSubstr("stopped by ada: 1 of its campaigns wait until a person"));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  ASSERT_TRUE(cell.resume());
  until(a, QueueState::done);
  cell.pass(600);
  EXPECT_EQ(state_of(b), QueueState::waiting);
  EXPECT_EQ(waits_for(b), "waits for a release of the queue, which is held: stopped by ada");
  release();
  until(b, QueueState::done);
}

TEST_F(QueueTest, AnAbortPutsTheEntryBackAndHoldsEvenWhereItWouldBeSetAside) {
  auto d = draft("a");
  d.on_failure = OnFailure::set_aside;
  const auto a = add(d);
  cell.until([&] { return cell.status().run && cell.status().run->run.accepted > 0; });
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, *look(a).run, "wrong sample")));
  until(a, QueueState::waiting);
  EXPECT_TRUE(hold().held);
  EXPECT_THAT(look(a).reason, HasSubstr("wrong sample"));
}

TEST_F(QueueTest, RepeatsFromStartToStart) {
  auto d = draft("check");
  d.repeat_every_s = 7200;
  const auto a = add(d);
  until(a, QueueState::done);
  const auto lines = cell->queue.list().lines;
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].entry.id.value, 2);
  EXPECT_EQ(lines[0].entry.not_before.ns - look(a).begun.utc_ns, 7'200'000'000'000);
  until(lines[0], QueueState::done);
  EXPECT_EQ(names_of_runs(), (std::vector<std::string>{"check", "check"}));
}

TEST_F(QueueTest, FitsAndNotifiesWhenTheRunIsDone) {
  auto d = draft("night 2");
  d.trajectory_text = lines_of(4, {-4, -2, 1, 3}, true);
  d.follow_ups = {"fit:q ~ x", "fit:q ~ x + pressure", "notify"};
  const auto a = add(d);
  auto next = draft("next");
  next.after = a.entry.id;
  const auto b = add(next);
  until(a, QueueState::done);
  const auto entry = look(a);
  ASSERT_EQ(entry.results.size(), 3u);
  EXPECT_TRUE(entry.results[0].good) << entry.results[0].text;
  ASSERT_TRUE(entry.results[0].model);
  EXPECT_TRUE(cell.await(cell->models.get(*entry.results[0].model)));
  EXPECT_FALSE(entry.results[1].good) << "this interferometer says no air pressure";
  EXPECT_EQ(cell.await(cell.run(*entry.run))->state, RunState::done) << "the run is not lost";
  EXPECT_FALSE(entry.accepted());
  EXPECT_THAT(waits_for(b), HasSubstr("which was not accepted"));
  const auto alarms = cell.await(cell->alarms.list(true, 100));
  const auto told = std::ranges::find(*alarms, "queue.done", &AlarmRecord::kind);
  ASSERT_NE(told, alarms->end());
  EXPECT_THAT(told->message,
              HasSubstr("queue entry 1 'night 2' is done: 20 of 20 rows accepted in run 1"));
}

TEST_F(QueueTest, RefusesWhatCannotBeAndKeepsNothingOfIt) {
  const auto reason_of = [&](const std::function<void(QueueDraft&)>& spoil) {
    auto d = draft("bad");
    spoil(d);
    const auto line = cell.await(cell->queue.add(cell.ada, d));
    return line ? std::string("taken") : line.error().reason;
  };
  EXPECT_EQ(reason_of([](auto& d) { d.trajectory_text = lines_of(1, {5.1}, false); }),
            "SOFT_LIMIT");
  EXPECT_EQ(reason_of([](auto& d) { d.condition = "t99 < 20 degC"; }), "BAD_CONDITION");
  EXPECT_EQ(reason_of([](auto& d) { d.after = QueueEntryId{1}; }), "QUEUE_CYCLE");
  EXPECT_EQ(reason_of([](auto& d) { d.after = QueueEntryId{7}; }), "NO_SUCH_QUEUE_ENTRY");
  EXPECT_EQ(reason_of([](auto& d) { d.follow_ups = {"dance"}; }), "BAD_FOLLOW_UP");
  EXPECT_EQ(reason_of([](auto& d) { d.follow_ups = {"fit:q ~ t99"}; }), "UNKNOWN_CHANNEL");
  EXPECT_EQ(reason_of([](auto& d) { d.follow_ups = {"diagnose:q ~ y"}; }), "UNKNOWN_CHANNEL");
  EXPECT_EQ(reason_of([](auto& d) { d.metadata = {{"no spaces", "x"}}; }), "BAD_METADATA");
  EXPECT_EQ(reason_of([](auto& d) { d.repeat_every_s = 5; }), "BAD_REPEAT");
  EXPECT_EQ(reason_of([](auto& d) { d.compensate = true; }), "NOTHING_TO_COMPENSATE");
  EXPECT_EQ(reason_of([](auto& d) { d.compensate_with = ModelId{3}; }), "NOTHING_TO_COMPENSATE");
  EXPECT_TRUE(cell->queue.list().lines.empty());
}

TEST_F(QueueTest, AnEntryThatHasBegunIsNeitherChangedNorRemoved) {
  const auto a = add(draft("a"));
  until(a, QueueState::running);
  EXPECT_EQ(cell.await(cell->queue.change(cell.ada, a.entry.id, {})).error().reason,
            "QUEUE_ENTRY_BEGUN");
  EXPECT_EQ(cell.await(cell->queue.move(cell.ada, a.entry.id, {})).error().message,
            "entry 1 'a' cannot be moved: it is running, run 1: abort that");
  EXPECT_EQ(cell.await(cell->queue.remove(cell.ada, {9}, "")).error().reason,
            "NO_SUCH_QUEUE_ENTRY");
}

TEST_F(QueueTest, TheSameRequestTwiceIsOneEntry) {
  auto d = draft("a");
  d.request_id = "7d0f";
  const auto first = add(d), again = add(d);
  EXPECT_EQ(first.entry.id, again.entry.id);
}

TEST_F(QueueTest, TagsOfARunAreSetRemovedAndFound) {
  const auto a = add(draft("a")), b = add(draft("b"));
  until(b, QueueState::done);
  const RunId run = *look(a).run;
  ASSERT_TRUE(
      cell.await(cell->runs.tag(cell.ada, run, {{"sample", "A12"}, {"tool", "probe"}}, {})));
  ASSERT_TRUE(cell.await(cell->runs.tag(cell.ada, run, {{"sample", "A13"}}, {"tool"})));
  EXPECT_EQ(metadata_text(cell.await(cell.run(run))->metadata), "sample=A13");
  const auto found = [&](const RunMetadata& wanted) {
    return cell.await(cell->records.metadata().find_runs(wanted, 0, 0))->size();
  };
  EXPECT_EQ(found({{"sample", "A13"}}), 1u);
  EXPECT_EQ(found({{"sample", "A1"}}), 0u);
  EXPECT_EQ(found({}), 2u);
  EXPECT_EQ(cell.await(cell->runs.tag(cell.ada, {9}, {}, {})).error().reason, "NO_SUCH_RUN");
}

// Kill -9 at a commit of the queue or of its runs: three entries, each becomes one run.
bool queue_dies(SharedWorld& world, const std::string& database, CellTime begin, int n) {
  const pid_t child = ::fork();
  if (child == 0) {
    int passed = 0;
    application::on_crash_point([&passed, n](std::string_view name) {
      const bool counts = name.ends_with("_queue_commit") || name.ends_with("_run_create_commit") ||
                          name.ends_with("_run_state_commit");
      if (counts && ++passed == n) ::raise(SIGKILL);
    });
    CellInMemory cell(*world, small_cell(database), kSqlite, begin);
    for (const char* name : {"a", "b", "c"}) {
      auto d = draft(name);
      d.request_id = name;
      if (!cell.await(cell->queue.add(cell.ada, d))) ::_exit(3);
    }
    cell.until([&] {
      for (const auto& line : cell->queue.list().lines)
        if (line.entry.state != QueueState::done) return false;
      return true;
    });
    cell.shut_down();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!WIFEXITED(status)) return true;
  EXPECT_EQ(WEXITSTATUS(status), 0);
  return false;
}

TEST(QueueKilled, MakesEachEntryOneRunAtAnyCommit) {
  int n = 1;
  for (;; ++n) {
    SCOPED_TRACE("killed at passing " + std::to_string(n));
    ASSERT_LT(n, 100);
    Folder folder;
    SharedWorld world;
    const auto database = folder / "cell.sqlite";
    if (!queue_dies(world, database, kWorldBegin, n)) break;
    ASSERT_FALSE(queue_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30));
    auto store = *storage::open_sqlite_store(database, true);
    const auto runs = *store->runs().runs(0, 0);
    ASSERT_EQ(runs.size(), 3u);
    std::string names;
    for (const auto& run : runs) {
      names = run.name + names;
      EXPECT_EQ(run.state, RunState::done) << run.reason;
      auto points = *store->points().points(run.id, 0, 100);
      std::erase_if(points, [](const PointRecord& point) { return point.passage; });
      std::set<std::int64_t> rows;
      for (const auto& point : points) rows.insert(point.row);
      EXPECT_EQ(rows.size(), 3u);
      EXPECT_EQ(points.size(), 3u);
    }
    EXPECT_EQ(names, "abc");
  }
  EXPECT_GT(n, 15) << "the crash points are there at all";
}

}  // namespace
}  // namespace driftwise::tests
