// A stop pressed while the controller cannot be reached: issue 11, number 13.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <utility>

#include "server/application/plumbing/crash_point.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/shared_world.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

const application::Caller kStopper{"bob", "ipv4:127.0.0.1:9", {}};
const std::string kStopRows = lines_of(2, {2, -3, 1}, true);

class Stopping : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};

  // Until the axis is on its long way from 2 to -3 mm.
  void begin_and_be_on_the_way() {
    cell.begin_run(kStopRows);
    cell.until([&] { return world.to_mm < -2.5 && cell.now().utc_ns < world.move_end_ns; });
  }
  RunRecord run() { return cell.status().run->run; }
  bool moving() const { return cell.now().utc_ns < world.move_end_ns; }
  std::vector<StopRecord> stored() {
    return (*kSqlite(folder / "cell.sqlite", true))->stops().pending().value();
  }
  std::vector<AlarmRecord> alarms() { return *cell.await(cell->alarms.list(false, 100)); }
};

// The end of the daemon: until the axes rest there is somebody who takes a stop.
TEST_F(Stopping, IsTakenWhileTheDaemonEndsUntilTheAxesRest) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  const auto lease = cell.lease();
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, lease, {2}, {}), moved);
  cell.until([&] { return moving(); });
  world.stop_does_nothing = true;
  bool rests = false;
  asio::co_spawn(cell.io(), cell.cell().come_to_rest(), [&](std::exception_ptr) { rests = true; });
  cell.until([&] { return world.stops > 0; });
  EXPECT_FALSE(rests) << "it moves";
  const auto refused = cell.await(cell->manual.home(cell.ada, lease));
  EXPECT_EQ(refused.error().reason, "SHUTTING_DOWN") << "nothing begins to move";
  EXPECT_TRUE(cell.await(cell->manual.stop_all(kStopper)));
  cell.until([&] { return rests; });
  EXPECT_FALSE(moving());
  ASSERT_TRUE(moved);
  EXPECT_FALSE(*moved);
  cell.shut_down();
  EXPECT_FALSE(cell.halt_not_on_record()) << "the stop is on record";
}

// The stop of the end cuts off what the movement by hand asks the controller meanwhile.
TEST_F(Stopping, IsNotPressedWhereTheEndOfTheDaemonCutsOffAMovementByHand) {
  for (const double cut_s : {0.01, 0.3, 3.0}) {
    world = {};
    CellInMemory ending{world, small_cell(folder / ("cut" + std::to_string(cut_s))), kSqlite};
    ASSERT_TRUE(ending.await(ending->manual.home(ending.ada, ending.lease())));
    const auto lease = ending.lease();
    std::optional<Result<void>> moved;
    ending.begin(ending->manual.move_to(ending.ada, lease, {2}, {}), moved);
    ending.until([&] { return ending.now().utc_ns < world.move_end_ns; });
    world.cut = true;
    bool rests = false;
    asio::co_spawn(ending.io(), ending.cell().come_to_rest(),
                   [&](std::exception_ptr) { rests = true; });
    ending.pass(cut_s);
    world.cut = false;
    ending.until([&] { return rests; });
    EXPECT_GE(ending.now().utc_ns, world.move_end_ns) << "halted";
    ASSERT_TRUE(moved);
    ASSERT_FALSE(*moved);
    EXPECT_EQ(moved->error().reason, "SHUTTING_DOWN") << cut_s;
    EXPECT_TRUE(ending.events_named("queue.held").empty()) << cut_s;
    EXPECT_TRUE(ending.events_named("stop.unconfirmed").empty()) << cut_s;
    EXPECT_TRUE(ending.status().pending_stops.empty()) << cut_s;
    ending.shut_down();
  }
}

// A controller that answers nothing until the daemon has ended: the next start sends the stop.
TEST_F(Stopping, OfAMovementByHandIsLeftToTheNextStartWhereTheAxesAreNotKnownToRest) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  const auto lease = cell.lease();
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, lease, {2}, {}), moved);
  cell.until([&] { return moving(); });
  world.axis_away = true;
  cell.shut_down();
  ASSERT_EQ(stored().size(), 1u);
  EXPECT_THAT(stored().front().cause, HasSubstr("the daemon ended during a movement by hand"));
}

TEST_F(Stopping, IsNotForgottenWhileTheConnectionIsDown) {
  begin_and_be_on_the_way();
  const int moves = world.moves;
  world.axis_away = true;
  const auto pressed = cell.now();
  const auto answer = cell.await(cell->manual.stop_all(kStopper));
  ASSERT_TRUE(answer);
  EXPECT_LE(seconds_from(cell.now() - pressed), 0.1);
  EXPECT_FALSE(answer->confirmed);
  EXPECT_THAT(answer->message, HasSubstr("not confirmed: use the emergency switch"));
  ASSERT_EQ(stored().size(), 1u) << "on disk before it was sent";
  EXPECT_EQ(stored().front().cause, "stopped by bob");

  cell.pass(0.5);
  ASSERT_TRUE(moving()) << "the axis is still on its way when the link comes back";
  world.axis_away = false;
  cell.until([&] { return run().state == RunState::paused; }, 10);
  EXPECT_GT(std::abs(world.to_mm + 3), 0.1) << "it halted on its way";
  EXPECT_EQ(world.moves, moves);
  EXPECT_TRUE(stored().empty());
  EXPECT_TRUE(cell.status().pending_stops.empty());
  EXPECT_EQ(cell.events_named("stop.unconfirmed").size(), 1u);
  EXPECT_EQ(cell.events_named("stop.confirmed").size(), 1u);

  cell.pass(600);
  EXPECT_EQ(run().state, RunState::paused) << "nothing starts it but a person";
  EXPECT_EQ(world.moves, moves);
  ASSERT_TRUE(cell.resume(kStopper));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(Stopping, RefusesEveryMotionWhileItIsPendingAndSaysSoEverywhere) {
  begin_and_be_on_the_way();
  world.axis_away = true;
  ASSERT_FALSE(cell.await(cell->manual.stop_all(kStopper))->confirmed);
  cell.pass(10);
  const auto expect_refused = [](const auto& done) {
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().reason, "STOP_PENDING");
    EXPECT_EQ(done.error().code, ErrorCode::failed_precondition);
    EXPECT_THAT(done.error().message, HasSubstr("use the emergency switch"));
  };
  expect_refused(cell.await(cell->runs.resume(cell.ada, run().id, {})));
  expect_refused(cell.await(cell->manual.home(cell.ada, cell.lease())));
  expect_refused(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1})));
  application::CreateRun request;
  request.trajectory_text = kStopRows;
  expect_refused(cell.try_run(request));

  const auto status = cell.status();
  EXPECT_EQ(status.run->run.state, RunState::waiting);
  EXPECT_THAT(status.run->run.reason, HasSubstr("use the emergency switch"));
  ASSERT_FALSE(status.attention.empty());
  EXPECT_THAT(status.attention.front(), HasSubstr("use the emergency switch"));
  int told = 0;
  for (const auto& alarm : alarms())
    if (alarm.kind == "stop.unconfirmed") {
      ++told;
      EXPECT_EQ(alarm.level, AlarmLevel::failed);
      EXPECT_EQ(alarm.subject, "axis");
      EXPECT_THAT(alarm.message, HasSubstr("use the emergency switch"));
    }
  EXPECT_EQ(told, 1);
  world.axis_away = false;
  cell.until([&] { return run().state == RunState::paused; }, 10);
  cell.pass(20);
  for (const auto& alarm : alarms()) {
    if (alarm.kind == "stop.unconfirmed") {
      EXPECT_NE(alarm.cleared.utc_ns, 0);
    }
  }
}

// Between two movements of a client that steers from outside: an indentation, a script.
TEST_F(Stopping, MovesNothingMoreForWhoHeldTheLease) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  const auto token = cell.lease();
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, token, {1})));
  ASSERT_TRUE(cell.await(cell->manual.stop_all(kStopper))->confirmed);
  cell.pass(10);
  const int moves = world.moves;
  const auto refused = cell.await(cell->manual.move_to(cell.ada, token, {2}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "STOPPED_MEANWHILE");
  EXPECT_THAT(refused.error().message, HasSubstr("stopped by bob"));
  EXPECT_EQ(world.moves, moves);
  EXPECT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {2})));
}

TEST_F(Stopping, AnAcknowledgementOfTheCommandIsNotEnough) {
  begin_and_be_on_the_way();
  world.stop_does_nothing = true;
  const auto answer = cell.await(cell->manual.stop_all(kStopper));
  EXPECT_FALSE(answer->confirmed);
  EXPECT_THAT(answer->message, HasSubstr("still reports motion"));
  cell.until([&] { return cell.status().pending_stops.empty(); }, 10);
  EXPECT_FALSE(moving()) << "confirmed only when nothing moved any more";
  cell.until([&] { return run().state == RunState::paused; }, 10);
}

TEST_F(Stopping, PressedAgainKeepsItsFirstPersonAndCounts) {
  begin_and_be_on_the_way();
  world.axis_away = true;
  static_cast<void>(cell.await(cell->manual.stop_all(kStopper)));
  static_cast<void>(cell.await(cell->manual.stop_all({"eve", "peer", {}})));
  ASSERT_EQ(stored().size(), 1u);
  EXPECT_EQ(stored().front().who, "bob");
  EXPECT_EQ(stored().front().presses, 2);
  world.axis_away = false;
  cell.until([&] { return run().state == RunState::paused; }, 10);
  EXPECT_EQ(run().reason, "stopped by eve");
}

TEST_F(Stopping, OfAMovementByHandHoldsWithoutARun) {
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, cell.lease(), {4}), moved);
  cell.until([&] { return moved || moving(); }, 60);
  if (moved) {  // never referenced
    moved.reset();
    ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
    cell.begin(cell->manual.move_to(cell.ada, cell.lease(), {4}), moved);
    cell.until([&] { return moving(); }, 60);
  }
  world.axis_away = true;
  EXPECT_FALSE(cell.await(cell->manual.stop_all(kStopper))->confirmed);
  world.axis_away = false;
  cell.until([&] { return cell.status().pending_stops.empty(); }, 10);
  EXPECT_LT(world.to_mm, 3.9);
  cell.until([&] { return moved.has_value(); }, 60);
  EXPECT_FALSE(*moved);
}

TEST_F(Stopping, IsThePauseOnRecordBeforeTheControllerHasConfirmedIt) {
  begin_and_be_on_the_way();
  world.axis_away = true;
  static_cast<void>(cell.await(cell->manual.stop_all(kStopper)));
  cell.until([&] { return run().state == RunState::waiting; }, 10);
  EXPECT_THAT(run().reason, HasSubstr("use the emergency switch"));
  cell.pass(1);
  const auto on_record = (*kSqlite(folder / "cell.sqlite", true))->runs().run(run().id).value();
  EXPECT_EQ(on_record.state, RunState::paused) << "what a kill leaves";
  EXPECT_EQ(on_record.hold.kind, RunHold::Kind::stop);
  EXPECT_EQ(on_record.hold.who, "bob");
}

// Bob stops everything, and every controller confirms it, while the database stores the new run.
class StoppedWhileCreated : public Stopping, public testing::WithParamInterface<const char*> {
 protected:
  StoppedWhileCreated() {
    application::on_crash_point([this](std::string_view name) {
      if (name != GetParam() || std::exchange(stopped, true)) return;
      EXPECT_TRUE(cell.await(cell->manual.stop_all(kStopper))->confirmed);
    });
  }
  ~StoppedWhileCreated() override { application::on_crash_point({}); }
  bool stopped = false;
};

TEST_P(StoppedWhileCreated, ARunIsPausedUntilAPersonResumesIt) {
  const auto created = cell.begin_run(kStopRows);
  ASSERT_TRUE(stopped);
  EXPECT_EQ(created.state, RunState::paused);
  EXPECT_EQ(created.reason, "stopped by bob");
  EXPECT_EQ(created.hold.kind, RunHold::Kind::stop);
  EXPECT_EQ(created.hold.who, "bob");
  cell.pass(600);
  EXPECT_EQ(run().state, RunState::paused);
  EXPECT_EQ(world.homes, 0);
  EXPECT_EQ(world.moves, 0);
  ASSERT_TRUE(cell.resume(kStopper));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

INSTANTIATE_TEST_SUITE_P(Side, StoppedWhileCreated,
                         testing::Values("before_run_create_commit", "after_run_create_commit"),
                         [](const auto& row) { return std::string(row.param); });

// Likewise while it stores the release of the queue.
TEST_F(Stopping, WhileTheQueueIsReleasedHoldsItOn) {
  ASSERT_TRUE(cell.await(cell->queue.hold(cell.ada, "all at once")));
  application::QueueDraft draft;
  draft.name = draft.trajectory_name = "a";
  draft.trajectory_text = kStopRows;
  const auto entry = cell.await(cell->queue.add(cell.ada, draft));
  ASSERT_TRUE(entry) << entry.error().message;
  bool stopped = false;
  application::on_crash_point([&](std::string_view name) {
    if (name != "after_queue_commit" || std::exchange(stopped, true)) return;
    EXPECT_TRUE(cell.await(cell->manual.stop_all(kStopper))->confirmed);
  });
  const auto released = cell.await(cell->queue.release(cell.ada));
  application::on_crash_point({});
  ASSERT_TRUE(stopped);
  ASSERT_FALSE(released);
  EXPECT_EQ(released.error().reason, "STOPPED_MEANWHILE");
  EXPECT_EQ(cell->queue.list().hold.why, "stopped by bob");
  cell.pass(600);
  EXPECT_EQ(cell->queue.get(entry->entry.id)->entry.state, QueueState::waiting);
  EXPECT_TRUE((*kSqlite(folder / "cell.sqlite", true))->queue().queue(10)->hold.held);
  EXPECT_TRUE(cell.await(cell->queue.release(cell.ada)));
}

TEST_F(Stopping, AnAbortIsRememberedToo) {
  begin_and_be_on_the_way();
  world.axis_away = true;
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, run().id, "wrong mirror")));
  EXPECT_EQ(stored().size(), 1u);
  cell.pass(0.5);
  ASSERT_TRUE(moving());
  world.axis_away = false;
  cell.until([&] { return cell.status().pending_stops.empty(); }, 10);
  EXPECT_GT(std::abs(world.to_mm + 3), 0.1);
}

// The daemon in a child, killed with an axis on its way; the world goes on.
void kill_on_the_way(SharedWorld& world, const std::string& database) {
  const pid_t child = ::fork();
  if (child == 0) {
    CellInMemory cell(*world, small_cell(database), kSqlite);
    cell.begin_run(kStopRows);
    cell.until([&] { return world->to_mm < -2.5 && cell.now().utc_ns < world->move_end_ns; });
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

// The same, killed when `when` says so.
void kill_when(SharedWorld& world, const std::string& database, const char* crash_point) {
  const pid_t child = ::fork();
  if (child == 0) {
    CellInMemory cell(*world, small_cell(database), kSqlite);
    cell.begin_run(kStopRows);
    cell.until([&] { return world->to_mm < -2.5 && cell.now().utc_ns < world->move_end_ns; });
    world->axis_away = std::string_view(crash_point) == "after_stop_commit";
    application::on_crash_point([crash_point](std::string_view name) {
      if (name == crash_point) ::raise(SIGKILL);
    });
    static_cast<void>(cell.await(cell->manual.stop_all(kStopper)));
    cell.pass(60);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << crash_point;
}

TEST(StopAndKill, APendingStopIsTheFirstCommandAfterARestartAndTheRunStaysPaused) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  kill_when(world, database, "after_stop_commit");
  world->axis_away = false;
  world->axis_calls = world->first_stop_call = 0;
  const int moves = world->moves, homes = world->homes;
  // While the controller is still on its way: time goes on where it was.
  const CellTime begin{world->move_begin_ns + 500'000'000};
  CellInMemory cell(*world, small_cell(database), kSqlite, begin);
  cell.until([&] { return cell.status().pending_stops.empty(); }, 10);
  EXPECT_EQ(world->first_stop_call, 1);
  EXPECT_GT(std::abs(world->to_mm + 3), 0.1) << "it halted on its way";
  cell.until([&] { return cell.status().run.has_value(); }, 10);
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  EXPECT_EQ(cell.status().run->run.reason, "stopped by bob");
  EXPECT_EQ(world->moves, moves);
  EXPECT_EQ(world->homes, homes);
  ASSERT_TRUE(cell.resume(kStopper));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST(StopAndKill, AConfirmedStopLeavesTheRunPausedThoughTheRunHadNotSeenIt) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  kill_when(world, database, "after_stop_confirm_commit");
  const int moves = world->moves;
  CellInMemory cell(*world, small_cell(database), kSqlite, kWorldBegin + std::chrono::hours(1));
  EXPECT_TRUE(cell.status().pending_stops.empty());
  cell.until([&] { return cell.status().run.has_value(); }, 10);
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  EXPECT_EQ(world->moves, moves);
}

// The daemon in a child, killed when it has just stored the new run; a stop came before or after.
void kill_when_created(SharedWorld& world, const std::string& database, const char* stopped_at) {
  const pid_t child = ::fork();
  if (child == 0) {
    CellInMemory cell(*world, small_cell(database), kSqlite);
    bool stopped = false;
    application::on_crash_point([&](std::string_view name) {
      if (name == stopped_at && !std::exchange(stopped, true))
        static_cast<void>(cell.await(cell->manual.stop_all(kStopper)));
      if (name == "after_run_create_commit") ::raise(SIGKILL);
    });
    cell.begin_run(kStopRows);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << stopped_at;
}

TEST(StopAndKill, AStopWhileTheRunWasCreatedLeavesItPausedThoughItNeverBegan) {
  for (const char* stopped_at : {"before_run_create_commit", "after_run_create_commit"}) {
    SCOPED_TRACE(stopped_at);
    Folder folder;
    SharedWorld world;
    const auto database = folder / "cell.sqlite";
    kill_when_created(world, database, stopped_at);
    CellInMemory cell(*world, small_cell(database), kSqlite, kWorldBegin + std::chrono::hours(1));
    cell.until([&] { return cell.status().run.has_value(); }, 10);
    cell.pass(600);
    EXPECT_EQ(cell.status().run->run.state, RunState::paused);
    EXPECT_EQ(cell.status().run->run.reason, "stopped by bob");
    EXPECT_EQ(world->homes, 0);
    EXPECT_EQ(world->moves, 0);
    ASSERT_TRUE(cell.resume(kStopper));
    const auto done = cell.finish_run();
    EXPECT_EQ(done.state, RunState::done);
    EXPECT_EQ(done.restarts, 0) << "it began only now";
  }
}

TEST(StopAndKill, AStopThatNoDaemonWasThereToTakeIsTheFirstCommandOfTheNext) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  kill_on_the_way(world, database);
  world->axis_calls = world->first_stop_call = 0;
  const int moves = world->moves, homes = world->homes;
  const CellTime begin{world->move_begin_ns + 500'000'000};
  CellInMemory cell(
      *world, small_cell(database), kSqlite,
      {.begin = begin, .kept_stop = formats::KeptStop{"bob", "2026-11-21T08:00:00Z"}});
  cell.until([&] { return cell.status().run && cell.status().pending_stops.empty(); }, 10);
  EXPECT_EQ(world->first_stop_call, 1);
  EXPECT_GT(std::abs(world->to_mm + 3), 0.1) << "it halted on its way";
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  EXPECT_EQ(cell.status().run->run.reason, "stopped by bob");
  EXPECT_EQ(world->moves, moves);
  EXPECT_EQ(world->homes, homes);
  EXPECT_THAT(cell.events_named("stop.kept"),
              testing::ElementsAre(HasSubstr("stopped by bob at 2026-11-21T08:00:00Z")));
  EXPECT_TRUE(cell->queue.list().hold.held) << "nor does a campaign begin by itself";
  ASSERT_TRUE(cell.resume(kStopper));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

}  // namespace
}  // namespace driftwise::tests
