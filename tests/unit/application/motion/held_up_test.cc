// Movements that do not end where they were sent: an obstacle in the way, a homing whose answer is
// damaged or whose line breaks, a limit of the cell that is exceeded while the axes are homed.
// Whatever ended them, the axes are at rest afterwards and stay there.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/application/holds/holds.h"
#include "server/application/manual/jogs.h"
#include "server/application/motion/run_control.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using application::JogOrder;
using application::JogState;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

// One axis at 1 mm/s. Its target stands behind an obstacle, as a servo's does, unless the
// controller ends the motion there.
struct Rail {
  VirtualTime* time = nullptr;
  double at_mm = 0, target_mm = 0;
  CellTime since = {};
  std::optional<double> obstacle_mm;
  bool ends_motion_there = false;
  bool searches = false;  // for its reference, until something stops it
  bool referenced = false;
  std::optional<Error> homing_ends_with;  // after 0.5 s, and the axis searches on
  bool is_away = false;
  int stops = 0, moves = 0;

  void look() {
    const auto now = time->now().utc;
    const double most_mm = since.utc_ns == 0 ? 0 : seconds_from(now - since);
    since = now;
    double next_mm = at_mm + std::clamp(target_mm - at_mm, -most_mm, most_mm);
    if (obstacle_mm && next_mm > *obstacle_mm) {
      next_mm = std::max(at_mm, *obstacle_mm);
      if (ends_motion_there) target_mm = next_mm;
    }
    at_mm = next_mm;
  }
  bool is_on_target() const { return !searches && std::abs(target_mm - at_mm) < 1e-6; }
  bool is_held_up() const { return obstacle_mm && at_mm >= *obstacle_mm - 1e-9; }
};

class RailController final : public MotionController {
 public:
  RailController(DeviceDescription description, Rail& rail)
      : description_(std::move(description)), rail_(rail) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override { return {}; }
  Awaitable<Result<void>> prepare() override { co_return answer(); }
  void close() override {}
  Awaitable<Result<MotionState>> state() override {
    DRIFTWISE_CO_RETURN_IF_ERROR(answer());
    rail_.look();
    MotionState state;
    state.at = rail_.time->now().utc;
    state.q_mm = {rail_.at_mm};
    state.moving = rail_.searches || (!rail_.is_on_target() && !rail_.is_held_up());
    state.referenced = rail_.referenced;
    state.on_target = rail_.is_on_target();
    co_return state;
  }
  Awaitable<Result<void>> home() override {
    if (auto here = answer(); !here) co_return here;
    rail_.referenced = false;
    rail_.searches = true;
    const int stops = rail_.stops;
    const double longest_s = rail_.homing_ends_with ? 0.5 : 20;
    const auto end = rail_.time->now().utc + nanoseconds_from_s(longest_s);
    while (rail_.time->now().utc < end && rail_.stops == stops)
      co_await rail_.time->sleep_until(rail_.time->now().utc + nanoseconds_from_s(0.1));
    if (rail_.stops != stops) co_return fail(ErrorCode::aborted, "STOPPED", "axis: stopped");
    if (rail_.homing_ends_with) co_return tl::unexpected(*rail_.homing_ends_with);
    rail_.searches = false;
    rail_.referenced = true;
    rail_.at_mm = rail_.target_mm = 0;
    co_return Result<void>{};
  }
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override {
    if (auto here = answer(); !here) co_return here;
    rail_.look();
    ++rail_.moves;
    rail_.target_mm = q_mm[0];
    co_return Result<void>{};
  }
  Awaitable<Result<void>> stop() override {
    if (auto here = answer(); !here) co_return here;
    rail_.look();
    ++rail_.stops;
    rail_.searches = false;
    rail_.target_mm = rail_.at_mm;
    co_return Result<void>{};
  }

 private:
  Result<void> answer() const {
    if (!rail_.is_away) return {};
    return fail(ErrorCode::unavailable, "NO_CONNECTION", "axis: no connection");
  }
  DeviceDescription description_;
  Rail& rail_;
};

class HeldUp : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  Rail rail;
  CellDescription described = small_cell(folder / "cell.sqlite");
  std::optional<CellInMemory> made;

  CellInMemory& cell() {
    if (!made) {
      const auto make = [this](VirtualTime& time, const CellDescription& description) {
        rail.time = &time;
        auto devices = small_devices(world, time, description);
        devices.front() = std::make_unique<RailController>(description.devices[0], rail);
        return devices;
      };
      made.emplace(make, described, kSqlite, CellInMemory::Further{});
    }
    return *made;
  }
  Result<void> home() { return cell().await(cell()->manual.home(cell().ada, cell().lease())); }
  Result<void> move_to(double q_mm) {
    return cell().await(cell()->manual.move_to(cell().ada, cell().lease(), {q_mm}));
  }
  Result<JogState> jog(JogOrder order) {
    return cell().await(cell()->jogs.begin(cell().ada, cell().lease(), std::move(order), {}));
  }
  // Where the axis is after the obstacle is gone and a minute has passed.
  double at_mm_when_the_way_is_free() {
    rail.obstacle_mm.reset();
    cell().pass(60);
    rail.look();
    return rail.at_mm;
  }
};

TEST_F(HeldUp, AHomingWhoseAnswerIsDamagedLeavesTheAxesAtRest) {
  rail.homing_ends_with = Error{ErrorCode::data_loss, "BAD_REPLY", "axis: a damaged answer"};
  const auto homed = home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().reason, "BAD_REPLY");
  EXPECT_FALSE(rail.searches) << "nobody looks at the axes any more";
  EXPECT_THAT(cell().events_named("axes.home_failed"), ElementsAre(HasSubstr("a damaged answer")));
  EXPECT_THAT(cell().status().attention, Contains(HasSubstr("no datum has been opened since")));
}

TEST_F(HeldUp, AHomingWhoseLineBreaksIsStoppedAsSoonAsTheControllerCanBeReached) {
  rail.homing_ends_with = Error{ErrorCode::unavailable, "NO_ANSWER", "axis: no answer"};
  std::optional<Result<void>> homed;
  cell().begin(cell()->manual.home(cell().ada, cell().lease()), homed);
  cell().until([this] { return rail.searches; });
  cell().pass(0.2);
  rail.is_away = true;
  cell().until([&] { return homed.has_value(); }, 60);
  ASSERT_FALSE(*homed);
  EXPECT_THAT(homed->error().message, HasSubstr("no answer"));
  EXPECT_THAT(homed->error().message, HasSubstr("use the emergency switch"));
  EXPECT_TRUE(rail.searches);
  EXPECT_THAT(cell().status().pending_stops, SizeIs(1));
  rail.is_away = false;
  cell().until([this] { return cell().status().pending_stops.empty(); }, 60);
  EXPECT_FALSE(rail.searches);
}

TEST_F(HeldUp, AMoveThatWasGivenUpGoesNowhereWhenTheWayIsFree) {
  rail.referenced = true;
  ASSERT_TRUE(move_to(1));
  rail.obstacle_mm = 1.2;
  const auto moved = move_to(2);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().reason, "NOT_SETTLED");
  EXPECT_THAT(moved.error().message, HasSubstr("halted"));
  EXPECT_NEAR(at_mm_when_the_way_is_free(), 1.2, 1e-6);
}

TEST_F(HeldUp, AStepAgainstAnObstacleIsNotMadeAndSaysHowFarTheAxisCame) {
  rail.referenced = true;
  ASSERT_TRUE(move_to(1));
  rail.obstacle_mm = 1.02;
  const auto step = jog({"q1_mm", 0.05, false});
  ASSERT_FALSE(step) << "the step was made";
  EXPECT_EQ(step.error().reason, "NOT_SETTLED");
  EXPECT_THAT(step.error().message, HasSubstr("q1_mm is at 1.020000 mm, +0.020000 mm from where "
                                              "a step of +0.05 mm began, and no nearer for 30 s"));
  EXPECT_EQ(rail.stops, 1);
  EXPECT_NEAR(at_mm_when_the_way_is_free(), 1.02, 1e-6);
}

// 600 nm short: less than the watch for motion without a command looks at, more than
// in_position_nm.
TEST_F(HeldUp, AStepIsNotMadeWhereTheControllerIsOnTargetElsewhere) {
  rail.referenced = true;
  ASSERT_TRUE(move_to(1));
  rail.obstacle_mm = 1.0004;
  rail.ends_motion_there = true;
  const auto step = jog({"q1_mm", 0.001, false});
  ASSERT_FALSE(step) << "the step was made";
  EXPECT_EQ(step.error().reason, "NOT_SETTLED");
  EXPECT_THAT(step.error().message,
              HasSubstr("q1_mm is at 1.000400 mm, +0.000400 mm from where a step of +0.001 mm "
                        "began, and the controller says that it is on target there"));
  EXPECT_EQ(rail.stops, 1);
  EXPECT_NEAR(at_mm_when_the_way_is_free(), 1.0004, 1e-7);
}

TEST_F(HeldUp, AHeldJogDoesNotRunAheadOfTheAxis) {
  rail.referenced = true;
  ASSERT_TRUE(move_to(1));
  rail.obstacle_mm = 1.12;
  rail.ends_motion_there = true;
  const auto lease = cell().lease();
  const auto begun = cell().await(cell()->jogs.begin(cell().ada, lease, {"q1_mm", 0.05, true}, {}));
  ASSERT_TRUE(begun);
  JogState state;
  for (int i = 0; i < 100 && !state.over; ++i) {
    cell().pass(0.1);
    state = cell()->jogs.hold(begun->id, lease).value();
    EXPECT_LE(rail.target_mm, 1.15 + 1e-6) << "one step ahead of the axis at most";
  }
  EXPECT_TRUE(state.over);
  EXPECT_FALSE(state.released);
  EXPECT_EQ(state.steps, 3);
  EXPECT_NE(state.end_reason, "");
  EXPECT_NEAR(at_mm_when_the_way_is_free(), 1.12, 1e-6);
}

class HeldUpByALimit : public HeldUp {
 protected:
  HeldUpByALimit() {
    HoldRule rule;
    rule.name = "support";
    rule.channel = "support_degC";
    rule.above = 23.5;
    rule.settle_s = 0;
    rule.action = HoldAction::stop;
    described.holds = {rule};
    ChannelLimitDescription never_frozen;  // the small world has no noise of its own
    never_frozen.channel = "support_degC";
    never_frozen.frozen_answers = 0;
    described.plausibility.limits.push_back(never_frozen);
  }
  void begin_and_be_homing() {
    cell().begin_run(lines_of(2, {2, -3, 1}, true));
    cell().until([this] { return rail.searches; }, 600);
  }
  RunRecord run() { return cell().status().run->run; }
};

TEST_F(HeldUpByALimit, AHomingIsStoppedWhenTheLimitIsExceeded) {
  begin_and_be_homing();
  world.support_degc = world.support_set_degc = 24;
  cell().until([this] { return !rail.searches; }, 30);
  EXPECT_FALSE(rail.referenced) << "it was stopped, and did not reach its reference";
  cell().until([this] { return run().state == RunState::waiting; }, 30);
  EXPECT_EQ(run().hold.kind, RunHold::Kind::condition);
  cell().pass(600);
  EXPECT_FALSE(rail.searches);
  world.support_degc = world.support_set_degc = 23;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_TRUE(rail.referenced);
}

// The limit is met again before the engine has looked: the halt is the cell's all the same.
TEST_F(HeldUpByALimit, AHaltIsTheCellsWhoeverLooksLate) {
  application::RunControl control(cell().io().get_executor());
  EXPECT_TRUE(control.set_condition(application::CellCondition{
      {RunHold::Kind::condition, "", cell().now(), "too warm"}, HoldAction::stop}));
  EXPECT_FALSE(control.set_condition({}));
  EXPECT_TRUE(control.halted_by_cell());
  EXPECT_EQ(control.hold().reason, "too warm");
  control.take_halt();
  EXPECT_FALSE(control.set_condition({}));
  EXPECT_FALSE(control.held());
  control.halt({RunHold::Kind::stop, "bob", cell().now(), "stopped by bob"});
  EXPECT_TRUE(control.set_condition(application::CellCondition{
      {RunHold::Kind::condition, "", cell().now(), "too warm"}, HoldAction::stop}));
  EXPECT_FALSE(control.halted_by_cell()) << "a person's stop stays a person's";
}

}  // namespace
}  // namespace driftwise::tests
