// Two robots in one cell: they move, settle, stop and fail together, and keep their distance.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <map>

#include "server/application/plumbing/crash_point.h"
#include "tests/unit/application/shared_world.h"
#include "tests/unit/application/sqlite.h"
#include "tests/unit/application/two_robots.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kBothRows = rows_of_both(2, {{2, 1.5}, {-3, 2}});

class SeveralRobots : public testing::Test {
 protected:
  Folder folder;
  SmallWorld ma, mn;
  CellInMemory cell{two_robot_devices(ma, mn), two_robot_cell(folder / "cell.sqlite"), kSqlite, {}};

  bool moves(const SmallWorld& world) const { return cell.now().utc_ns < world.move_end_ns; }
  void begin_and_be_on_the_way() {
    cell.begin_run(rows_of_both(1, {{2, 2}, {-4, -4}}));
    cell.until([&] { return ma.to_mm < -3.5 && mn.to_mm < -3.5 && moves(ma) && moves(mn); });
  }
  RunRecord run() { return cell.status().run->run; }
  std::vector<PointRecord> points(RunId run) { return *cell.await(cell.points(run, 0, 1000)); }
  std::string refusal_of(const std::string& csv) {
    application::CreateRun request;
    request.trajectory_name = "plan.csv";
    request.trajectory_text = csv;
    const auto run = cell.try_run(std::move(request));
    EXPECT_FALSE(run) << csv;
    return run ? std::string() : run.error().reason + ": " + run.error().message;
  }
};

double value_of(const PointRecord& point, const std::string& channel) {
  for (const auto& value : point.values)
    if (value.channel == channel) return value.value;
  return kMissing;
}

TEST_F(SeveralRobots, ArriveTogetherAndEveryPointHasBoth) {
  const auto begun = cell.begin_run(kBothRows);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto all = points(begun.id);
  ASSERT_EQ(all.size(), 6u);
  for (const auto& point : all) {
    ASSERT_EQ(point.commanded_mm.size(), 2u);
    EXPECT_NEAR(value_of(point, "ma.q1_mm"), point.commanded_mm[0], 100e-6);
    EXPECT_NEAR(value_of(point, "mn.q1_mm"), point.commanded_mm[1], 100e-6);
    EXPECT_NEAR(value_of(point, "ma.x_mm"), point.commanded_mm[0], 2e-3);
  }
  EXPECT_EQ(all[1].commanded_mm, (std::vector<double>{2, 1.5}));
  EXPECT_NEAR(ma.to_mm, 0, 1e-3) << "parked";
  EXPECT_NEAR(mn.to_mm, 0, 1e-3);
}

// Order of the cell file's devices: ma before mn, with one axis each.
TEST_F(SeveralRobots, HaveTheirCommandsUnderTheNamesOfTheirMotors) {
  const auto begun = cell.begin_run(kBothRows);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  for (const auto& point : points(begun.id)) {
    EXPECT_EQ(value_of(point, "ma.q1_cmd_mm"), point.commanded_mm[0]);
    EXPECT_EQ(value_of(point, "mn.q1_cmd_mm"), point.commanded_mm[1]);
  }
  const auto data = cell.await(cell.read([&begun](Store& store) {
    return store.runs().dataset({&begun.id, 1});
  }));
  ASSERT_TRUE(data) << data.error().message;
  for (const char* symbol : {"ma.q1_cmd", "mn.q1_cmd"}) {
    const auto* command = data->find(symbol);
    ASSERT_NE(command, nullptr) << symbol;
    EXPECT_THAT(command->values, testing::Each(testing::Not(testing::IsNan()))) << symbol;
  }
  EXPECT_EQ(data->find("q1_cmd"), nullptr);
  EXPECT_EQ(data->find("q2_cmd"), nullptr);
}

TEST_F(SeveralRobots, OneThatNoRowNamesStaysAtItsZero) {
  const auto begun = cell.begin_run(
      "mn.q1_mm,set,line,zero\n0,calibration,1,1\n2,calibration,1,0\n-3,calibration,1,0\n");
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(mn.furthest_mm, 3);
  EXPECT_EQ(ma.furthest_mm, 0);
  EXPECT_EQ(ma.moves, 2) << "to the zero of the datum, and parked";
  const auto all = points(begun.id);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[1].commanded_mm, (std::vector<double>{0, 2}));
  EXPECT_NEAR(value_of(all[1], "ma.q1_mm"), 0, 100e-6);
}

TEST_F(SeveralRobots, TheZeroWaitsForAllOfThem) {
  mn.creeping = true;
  const auto begun =
      cell.begin_run("ma.q1_mm,set,line,zero\n0,calibration,1,1\n2,calibration,1,0\n");
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::failed) << "all axes must stand at the zero";
  EXPECT_THAT(ended.reason, HasSubstr("nm"));
  EXPECT_TRUE(points(begun.id).empty());
}

TEST_F(SeveralRobots, HaltTogether) {
  begin_and_be_on_the_way();
  const auto answer = cell.await(cell->manual.stop_all(cell.ada));
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->confirmed) << answer->message;
  EXPECT_THAT(answer->message, AllOf(HasSubstr("axis"), HasSubstr("second")));
  for (const auto* world : {&ma, &mn}) {
    EXPECT_FALSE(moves(*world));
    EXPECT_GT(world->to_mm, -3.9) << "on its way";
  }
  cell.until([&] { return run().state == RunState::paused; });
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(SeveralRobots, StopWhenOneOfThemFails) {
  begin_and_be_on_the_way();
  mn.axis_away = true;
  cell.until([&] { return ma.stops > 0; }, 5);
  cell.until([&] { return !moves(ma); }, 5);
  EXPECT_GT(ma.to_mm, -3.9) << "halted on its way, for the other cannot be asked";
  cell.until([&] { return run().state == RunState::waiting; }, 5);
  mn.axis_away = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(SeveralRobots, AreHomedOneAfterTheOther) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  EXPECT_EQ(ma.homes, 1);
  EXPECT_EQ(mn.homes, 1);
  EXPECT_TRUE(ma.referenced && mn.referenced);
}

TEST_F(SeveralRobots, OneIsMovedByHandAndTheOtherIsNotTold) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  const int told = mn.moves;
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {2, kMissing}, {})));
  EXPECT_NEAR(ma.to_mm, 2, 1e-3);
  EXPECT_EQ(mn.moves, told);
  const int moves_of_ma = ma.moves;
  ASSERT_TRUE(cell.await(cell->jogs.begin(cell.ada, cell.lease(), {"mn.q1_mm", 0.5, false}, {})));
  EXPECT_NEAR(mn.to_mm, 0.5, 1e-3);
  EXPECT_EQ(ma.moves, moves_of_ma);
  EXPECT_THAT(cell.events_named("axes.move").back(), HasSubstr("ma.q1 2"));
}

// At rest, and never on target by what its controller says.
class Restless final : public MotionController {
 public:
  explicit Restless(std::unique_ptr<MotionController> of) : of_(std::move(of)) {}
  const DeviceDescription& description() const override { return of_->description(); }
  DeviceHealth health() const override { return of_->health(); }
  Awaitable<Result<void>> prepare() override { return of_->prepare(); }
  void close() override { of_->close(); }
  Awaitable<Result<MotionState>> state() override {
    auto state = co_await of_->state();
    if (state) state->on_target = false;
    co_return state;
  }
  Awaitable<Result<void>> home() override { return of_->home(); }
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override {
    return of_->start_move(q_mm);
  }
  Awaitable<Result<void>> stop() override { return of_->stop(); }

 private:
  std::unique_ptr<MotionController> of_;
};

TEST(SeveralRobotsOneRestless, HoldsNobodyElse) {
  Folder folder;
  SmallWorld ma, mn;
  ma.referenced = mn.referenced = true;
  const auto make = [&](VirtualTime& time, const CellDescription& cell) {
    auto devices = two_robot_devices(ma, mn)(time, cell);
    auto& port = std::get<std::unique_ptr<MotionController>>(devices.back().port);
    port = std::make_unique<Restless>(std::move(port));
    return devices;
  };
  CellInMemory cell(make, two_robot_cell(folder / "cell.sqlite"), kSqlite, {});
  const auto begun = cell.now();
  const auto moved = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {2, kMissing}, {}));
  ASSERT_TRUE(moved) << moved.error().message;
  EXPECT_TRUE(cell.await(cell->jogs.begin(cell.ada, cell.lease(), {"ma.q1_mm", 0.5, false}, {})));
  EXPECT_LT(seconds_from(cell.now() - begun), 30);
}

TEST_F(SeveralRobots, OneIsNotMovedWhileTheOtherIsStillUnderWay) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  ma.move_begin_ns = cell.now().utc_ns;
  ma.move_end_ns = ma.move_begin_ns + nanoseconds_from_s(3600).count();
  const int told = mn.moves, homes = ma.homes;
  const auto moved = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 2}, {}));
  ASSERT_FALSE(moved) << "nobody knows where ma will be";
  EXPECT_EQ(moved.error().reason, "MOVING");
  EXPECT_THAT(moved.error().message, HasSubstr("ma.q1_mm is still moving"));
  const auto jogged =
      cell.await(cell->jogs.begin(cell.ada, cell.lease(), {"mn.q1_mm", 0.5, false}, {}));
  ASSERT_FALSE(jogged);
  EXPECT_EQ(jogged.error().reason, "MOVING");
  const auto homed = cell.await(cell->manual.home(cell.ada, cell.lease(), {}));
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().reason, "MOVING");
  EXPECT_EQ(mn.moves, told);
  EXPECT_EQ(ma.homes, homes);
  EXPECT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {2, kMissing}, {})))
      << "its own controller is told anew";
  EXPECT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 1}, {})));
}

TEST_F(SeveralRobots, AMoveByHandThatComesNoNearerIsHalted) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, cell.lease(), {2, kMissing}, {}), moved);
  cell.until([&] { return moves(ma); });
  ma.to_mm = ma.from_mm;  // jammed: its controller reports motion
  ma.move_end_ns = ma.move_begin_ns + nanoseconds_from_s(3600).count();
  cell.until([&] { return moved.has_value(); }, 60);
  ASSERT_FALSE(*moved);
  EXPECT_EQ(moved->error().reason, "NOT_SETTLED");
  EXPECT_THAT(moved->error().message,
              HasSubstr("no nearer for 30 s (move_timeout_s), limit 150 nm, still moving: halted"));
  EXPECT_GE(ma.stops, 1);
  EXPECT_FALSE(moves(ma));
  EXPECT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 2}, {})));
}

TEST_F(SeveralRobots, AMoveByHandThatNoHaltEndsGetsTheStopThatIsNotForgotten) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, cell.lease(), {2, kMissing}, {}), moved);
  cell.until([&] { return moves(ma); });
  ma.to_mm = ma.from_mm;
  ma.move_end_ns = ma.move_begin_ns + nanoseconds_from_s(3600).count();
  ma.stop_does_nothing = true;
  cell.until([&] { return moved.has_value(); }, 60);
  ASSERT_FALSE(*moved);
  ASSERT_FALSE(cell.status().pending_stops.empty());
  EXPECT_THAT(cell.status().pending_stops.front().cause, HasSubstr("halted and still move"));
  const auto next = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 2}, {}));
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().reason, "STOP_PENDING");
}

TEST_F(SeveralRobots, AMoveByHandWhoseControllerIsLostIsHaltedToo) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  std::optional<Result<void>> moved;
  cell.begin(cell->manual.move_to(cell.ada, cell.lease(), {4, kMissing}, {}), moved);
  cell.until([&] { return moves(ma); });
  ma.axis_away = true;
  cell.until([&] { return ma.stops > 0; }, 5);
  ma.axis_away = false;  // the link is back while the stop is under way
  cell.until([&] { return moved.has_value(); }, 60);
  EXPECT_FALSE(*moved);
  EXPECT_FALSE(moves(ma));
  EXPECT_LT(ma.to_mm, 3.9);
}

TEST_F(SeveralRobots, EachOfThemIsWatchedForMotionOfNobody) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  cell.pass(10);
  mn.from_mm = mn.to_mm = 0.5;
  cell.pass(10);
  const auto seen = cell.events_named("motion.uncommanded");
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_THAT(seen.front(), HasSubstr("mn.q1"));
}

TEST_F(SeveralRobots, KeepTheirDistanceAtTheEndOfEveryMove) {
  const auto refused = refusal_of(rows_of_both(1, {{2, 2}, {3, 2.5}}));
  EXPECT_THAT(refused, AllOf(HasSubstr("KEEP_OUT: plan.csv: row 3: robots ma and mn"),
                             HasSubstr("-0.5 mm"), HasSubstr("'tips' asks for 1 mm")));
  EXPECT_EQ(ma.moves + mn.moves, 0) << "refused before motion";
}

TEST_F(SeveralRobots, KeepTheirDistanceOnTheWay) {
  // 4 mm at either end; in between both may be at 4 mm of their axes.
  const auto refused = refusal_of(rows_of_both(1, {{4, -3}, {-3, 4}}));
  EXPECT_THAT(refused, AllOf(HasSubstr("row 3"), HasSubstr("on the way from 4 to 4 mm"),
                             HasSubstr("-3 mm")));
  EXPECT_EQ(ma.moves + mn.moves, 0);
  cell.begin_run(rows_of_both(1, {{4, -3}, {-3, -3}, {-3, 4}}));
  EXPECT_EQ(cell.finish_run().state, RunState::done) << "one after the other";
}

TEST_F(SeveralRobots, KeepTheirDistanceOnTheReturnToZero) {
  // Without rows for it, the axes return after each line by themselves, both at once.
  const auto refused =
      refusal_of("ma.q1_mm,mn.q1_mm,set,line,zero\n-5,0,calibration,1,0\n-5,5,calibration,1,0\n");
  EXPECT_THAT(refused,
              AllOf(HasSubstr("KEEP_OUT"), HasSubstr("row 2, the return to zero after it")));
}

TEST_F(SeveralRobots, KeepTheirDistanceByHand) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {4, kMissing}, {})));
  const int told = mn.moves;
  const auto moved = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 2}, {}));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().reason, "KEEP_OUT");
  const auto far = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, -0.5}, {}));
  ASSERT_TRUE(far) << far.error().message;
  const auto jogged =
      cell.await(cell->jogs.begin(cell.ada, cell.lease(), {"mn.q1_mm", 0.8, false}, {}));
  ASSERT_FALSE(jogged);
  EXPECT_EQ(jogged.error().reason, "KEEP_OUT");
  EXPECT_EQ(mn.moves, told + 1);
}

TEST_F(SeveralRobots, KeepTheirDistanceWhileTheyAreHomed) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {-4, kMissing}, {})));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 4.5}, {})));
  const int homed = ma.homes;
  const auto refused = cell.await(cell->manual.home(cell.ada, cell.lease(), {}));
  ASSERT_FALSE(refused) << "ma would come to its zero while mn is still at 4.5 mm";
  EXPECT_EQ(refused.error().reason, "KEEP_OUT");
  EXPECT_EQ(ma.homes, homed) << "refused before motion";
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 0}, {})));
  EXPECT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
}

TEST_F(SeveralRobots, OneMakesRoomWhereNoRowLeftThem) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease(), {})));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {-5, kMissing}, {})));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing, 5}, {})));
  const auto both = cell.await(cell->manual.move_to(cell.ada, cell.lease(), {0, 0}, {}));
  ASSERT_FALSE(both) << "by hand the person says who moves first";
  const int before = ma.moves + mn.moves;
  cell.begin_run(rows_of_both(1, {{1, 1}}));
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  // To the zero one after the other, then all axes of the controllers as ever.
  EXPECT_GE(ma.moves + mn.moves, before + 3);
}

TEST_F(SeveralRobots, ATrajectorySaysWhoseItsCoordinatesAre) {
  const std::string rest = ",set\n0,calibration\n";
  EXPECT_THAT(refusal_of("q1_mm" + rest),
              AllOf(HasSubstr("WRONG_COORDINATES"), HasSubstr("column q1_mm"),
                    HasSubstr("robots ma, mn"), HasSubstr("ma.q1_mm")));
  EXPECT_THAT(refusal_of("mx.q1_mm" + rest), HasSubstr("no robot 'mx', its robots are ma, mn"));
  EXPECT_THAT(refusal_of("ma.q2_mm" + rest),
              HasSubstr("robot 'ma' has no such axis, its axes are ma.q1_mm"));
  EXPECT_THAT(refusal_of("ma.x_mm" + rest), HasSubstr("hand in motor coordinates"));
}

// The daemon dies at every commit of the run in turn; both robots go on where the run was.
TEST(SeveralRobotsKilled, NoPointIsLostAndNoneIsDoubled) {
  for (int n = 1; n < 40; ++n) {
    Folder folder;
    SharedWorld ma, mn;
    const std::string database = folder / "cell.sqlite";
    const auto live = [&](bool begins, CellTime begin, int dies_at) {
      const pid_t child = ::fork();
      if (child == 0) {
        int passed = 0;
        application::on_crash_point([&](std::string_view name) {
          const bool counts =
              !name.ends_with("_readings_commit") && !name.ends_with("_event_commit");
          if (counts && ++passed == dies_at) ::raise(SIGKILL);
        });
        CellInMemory cell(two_robot_devices(*ma, *mn), two_robot_cell(database), kSqlite,
                          {.begin = begin});
        if (begins) cell.begin_run(kBothRows);
        const auto ended = cell.finish_run();
        cell.shut_down();
        ::_exit(ended.state == RunState::done ? 0 : 3);
      }
      int status = 0;
      ::waitpid(child, &status, 0);
      if (WIFSIGNALED(status)) return true;
      EXPECT_EQ(WEXITSTATUS(status), 0) << n;
      return false;
    };
    if (!live(true, kWorldBegin, n)) {
      EXPECT_GT(n, 6) << "as often as there are points at least";
      return;
    }
    const auto store = kSqlite(database, true);
    const auto runs = (*store)->runs().runs(1, 0).value();
    if (runs.empty()) continue;  // before it was created
    if (!is_over(runs.front().state)) live(false, kWorldBegin + std::chrono::hours(1), 0);
    std::map<std::int64_t, int> accepted;
    const auto stored = (*store)->points().points(RunId{1}, 0, 100).value();
    for (const auto& point : stored)
      if (!point.passage) ++accepted[point.row];
    EXPECT_EQ(accepted.size(), 6u) << n;
    for (const auto& [row, times] : accepted) EXPECT_EQ(times, 1) << n << ", row " << row;
  }
}

}  // namespace
}  // namespace driftwise::tests
