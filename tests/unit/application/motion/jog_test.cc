// Jog: a bounded step, a held button, and a client that falls silent. Virtual time: its clock is
// the wall's here (tests/integration/cell/jog_test.cc has the real one).

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <cmath>

#include "server/application/manual/jogs.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using application::JogOrder;
using application::JogState;
using testing::HasSubstr;
using testing::SizeIs;

class Jogging : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  std::string lease;

  void SetUp() override {
    ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
    lease = cell.lease();
  }
  Result<JogState> begin(JogOrder order, application::HoldAnswer answer = {}) {
    return cell.await(cell->jogs.begin(cell.ada, lease, std::move(order), std::move(answer)));
  }
  JogState sign(std::int64_t id) { return cell->jogs.hold(id, lease).value(); }
  // Signs every 100 ms for so long.
  JogState hold_for(std::int64_t id, double seconds) {
    JogState state;
    for (int i = 0; i < static_cast<int>(10 * seconds); ++i) {
      cell.pass(0.1);
      state = sign(id);
    }
    return state;
  }
  double q_mm() const { return world.to_mm + world.reference_mm; }
};

TEST_F(Jogging, MovesOneAxisByOneStepAndSaysWhereItIs) {
  const double before = q_mm();
  const auto jog = begin({"q1_mm", 0.001, false});
  ASSERT_TRUE(jog) << jog.error().message;
  EXPECT_TRUE(jog->over);
  EXPECT_TRUE(jog->released);
  EXPECT_EQ(jog->steps, 1);
  // The readback holds its place by 8 nm.
  EXPECT_NEAR(q_mm() - before, 0.001, 60e-6);
  EXPECT_NEAR(jog->q_mm.at(0), q_mm(), 60e-6);
  EXPECT_THAT(cell.events_named("axes.jog"), SizeIs(1));
}

TEST_F(Jogging, ASlowStepTakesAsLongAsItComesNearer) {
  std::optional<Result<JogState>> jog;
  cell.begin(cell->jogs.begin(cell.ada, lease, {"q1_mm", 1, false}, {}), jog);
  const int moves = world.moves;
  cell.until([&] { return world.moves > moves; });
  world.move_end_ns = world.move_begin_ns + nanoseconds_from_s(90).count();
  cell.until([&] { return jog.has_value(); }, 120);
  ASSERT_TRUE(*jog) << jog->error().message;
  EXPECT_TRUE((*jog)->released) << "three times move_timeout_s";
}

TEST_F(Jogging, ThatCannotBePutOnRecordMovesNothing) {
  sqlite3* other = nullptr;  // another program that holds the database
  ASSERT_EQ(sqlite3_open((folder / "cell.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const int moves = world.moves;
  const auto refused = begin({"q1_mm", 0.9, false});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("another program holds the database"));
  EXPECT_EQ(world.moves, moves);
  ASSERT_EQ(sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  lease = cell.lease();
  EXPECT_TRUE(begin({"q1_mm", 0.9, false}));
  EXPECT_EQ(world.moves, moves + 1);
}

TEST_F(Jogging, RefusesWhatIsNoBoundedStepAndNothingMoves) {
  const int moves = world.moves;
  EXPECT_EQ(begin({"q7_mm", 0.001, false}).error().reason, "UNKNOWN_AXIS");
  EXPECT_EQ(begin({"q1_mm", 0, false}).error().reason, "BAD_STEP");
  EXPECT_EQ(begin({"q1_mm", -1.5, true}).error().reason, "BAD_STEP");
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, lease, {4.9995})));
  EXPECT_EQ(begin({"q1_mm", 0.5, true}).error().reason, "SOFT_LIMIT");
  EXPECT_EQ(world.moves, moves + 1) << "the way to the limit alone";
  lease = "of nobody";
  EXPECT_EQ(begin({"q1_mm", 0.001, false}).error().reason, "LEASE_HELD");
  EXPECT_EQ(cell->jogs.hold(1, lease).error().reason, "NO_SUCH_JOG");
}

TEST_F(Jogging, StepsFollowEachOtherForAsLongAsTheButtonIsHeld) {
  const double before = q_mm();
  const auto jog = begin({"q1_mm", -0.01, true});
  ASSERT_TRUE(jog);
  EXPECT_FALSE(jog->over);
  const auto held = hold_for(jog->id, 3);
  EXPECT_FALSE(held.over);
  EXPECT_GT(held.steps, 2);
  const auto ended = cell.await(cell->jogs.end(jog->id, lease));
  ASSERT_TRUE(ended);
  EXPECT_TRUE(ended->released);
  EXPECT_GE(world.stops, 1) << "the driver's own stop";
  EXPECT_LT(q_mm(), before - 0.01);
  const double here = q_mm();
  cell.pass(10);
  EXPECT_EQ(q_mm(), here);
}

TEST_F(Jogging, ASilentClientStopsTheAxisAfter300Milliseconds) {
  const auto jog = begin({"q1_mm", 1, true});
  ASSERT_TRUE(jog);
  hold_for(jog->id, 0.2);
  const auto silent = cell.now();
  cell.until([&] { return world.stops > 0; }, 5);
  const double took_s = seconds_from(cell.now() - silent);
  EXPECT_GE(took_s, 0.29);
  EXPECT_LE(took_s, 0.35);
  cell.pass(1);
  const auto over = sign(jog->id);
  EXPECT_TRUE(over.over);
  EXPECT_FALSE(over.released);
  EXPECT_THAT(over.end_reason, HasSubstr("no sign of the client of ada for 300 ms"));
  EXPECT_THAT(cell.events_named("axes.jog_lost"), SizeIs(1));
  const double here = q_mm();
  cell.pass(20);
  EXPECT_EQ(q_mm(), here) << "and no further step begins";
  EXPECT_TRUE(begin({"q1_mm", 0.001, false})) << "the next one may begin";
}

TEST_F(Jogging, AControllerThatMovesOnGetsTheStopThatIsNotForgotten) {
  const auto jog = begin({"q1_mm", 1, true});
  ASSERT_TRUE(jog);
  cell.until([&] { return world.moves > 1; }, 5);
  world.stop_does_nothing = true;
  world.move_end_ns = world.move_begin_ns + 60'000'000'000;  // a minute's way
  cell.until([&] { return !cell.status().pending_stops.empty(); }, 30);
  EXPECT_THAT(cell.status().pending_stops.front().cause, HasSubstr("no sign of the client"));
}

TEST_F(Jogging, AStopEndsIt) {
  const auto jog = begin({"q1_mm", 0.5, true});
  ASSERT_TRUE(jog);
  hold_for(jog->id, 0.2);
  static_cast<void>(cell.await(cell->manual.stop_all({"bob", "ipv4:127.0.0.1:9", {}})));
  cell.pass(0.5);
  const auto over = sign(jog->id);
  EXPECT_TRUE(over.over);
  EXPECT_FALSE(over.released);
  EXPECT_EQ(over.end_reason, "stopped by bob");
  EXPECT_THAT(cell.events_named("axes.jog_lost"), SizeIs(0));
}

TEST_F(Jogging, WorksWhileARunIsPausedAndTheRunMeasuresItsZeroAgain) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 2; });
  EXPECT_EQ(begin({"q1_mm", 0.001, false}).error().reason, "RUN_UNDER_WAY");
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run.id)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_EQ(begin({"q1_mm", 0.001, false}).error().reason, "HOLD_NOT_NAMED");
  const auto datums = cell.await(cell.datums(run.id))->size();
  ASSERT_TRUE(begin({"q1_mm", 0.001, false}, cell.answer()));
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_GT(cell.await(cell.datums(run.id))->size(), datums);
}

// Two axes that are at once where they were sent.
class TwoAxes final : public MotionController {
 public:
  TwoAxes(DeviceDescription description, VirtualTime& time, std::vector<double>& q_mm, int& moves)
      : description_(std::move(description)), time_(time), q_mm_(q_mm), moves_(moves) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override { return {}; }
  Awaitable<Result<void>> prepare() override { co_return Result<void>{}; }
  void close() override {}
  Awaitable<Result<MotionState>> state() override {
    co_return MotionState{time_.now().utc, q_mm_, false, true, true};
  }
  Awaitable<Result<void>> home() override { co_return Result<void>{}; }
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override {
    ++moves_;
    q_mm_.assign(q_mm.begin(), q_mm.end());
    co_return Result<void>{};
  }
  Awaitable<Result<void>> stop() override { co_return Result<void>{}; }

 private:
  DeviceDescription description_;
  VirtualTime& time_;
  std::vector<double>& q_mm_;
  int& moves_;
};

// A micrometre of q1 while q2, whose limits are -50 to 50 mm, is at q_mm[1].
Result<JogState> jog_one_of_two(std::vector<double>& q_mm, int& moves) {
  Folder folder;
  SmallWorld world;
  auto described = small_cell(folder / "cell.sqlite");
  described.devices[0].become<MotionSettings>().axes.push_back({{"q2", "mm"}, "Y", -50, 50, 20});
  const auto make = [&](VirtualTime& time, const CellDescription& cell) {
    auto devices = small_devices(world, time, cell);
    devices.front() = std::make_unique<TwoAxes>(cell.devices[0], time, q_mm, moves);
    return devices;
  };
  CellInMemory cell(make, described, kSqlite, {});
  return cell.await(cell->jogs.begin(cell.ada, cell.lease(), {"q1_mm", 0.001, false}, {}));
}

TEST(JoggingOneOfTwoAxes, SendsTheOtherOneToItsLimitFromWithinItsNoise) {
  std::vector<double> q_mm{0, 50 + 8e-6};
  int moves = 0;
  const auto jog = jog_one_of_two(q_mm, moves);
  ASSERT_TRUE(jog) << jog.error().message;
  EXPECT_EQ(moves, 1);
  EXPECT_EQ(q_mm, (std::vector<double>{0.001, 50}));
}

TEST(JoggingOneOfTwoAxes, IsRefusedWhereTheOtherOneWouldBeDrivenToItsLimit) {
  std::vector<double> q_mm{0, 52};
  int moves = 0;
  const auto jog = jog_one_of_two(q_mm, moves);
  ASSERT_FALSE(jog) << "2 mm at full speed, with a step of a micrometre";
  EXPECT_EQ(jog.error().reason, "SOFT_LIMIT");
  EXPECT_THAT(jog.error().message, HasSubstr("q2_mm is at 52.000000 mm"));
  EXPECT_EQ(moves, 0);
  EXPECT_EQ(q_mm, (std::vector<double>{0, 52}));
}

}  // namespace
}  // namespace driftwise::tests
