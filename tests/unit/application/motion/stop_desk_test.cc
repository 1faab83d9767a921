// The desk by itself: several controllers, a disk that refuses or hangs.

#include "server/application/motion/stop_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>

#include "server/application/plumbing/task_group.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::application {
namespace {

using testing::HasSubstr;
using tests::VirtualClock;
using tests::VirtualTime;

struct Motor {
  bool away = false, moving = false;
  int stops = 0, questions = 0;
};

// Counts the writes of stops, and refuses them when it is told to.
class StopsOnly final : public Store, StopStore {
 public:
  StopsOnly(std::unique_ptr<Store> under, int& keeps, const bool& refuses)
      : Store(before(*under, this)), under_(std::move(under)), keeps_(keeps), refuses_(refuses) {}

 private:
  static StoreParts before(Store& under, StopsOnly* its) {
    StoreParts parts = under.parts();
    parts.stops = its;
    parts.upkeep = nullptr;
    return parts;
  }
  Result<std::vector<StopRecord>> keep(std::span<const StopRecord> stops) override {
    ++keeps_;
    if (refuses_) return fail(ErrorCode::resource_exhausted, "DISK_FULL", "no room");
    return under_->stops().keep(stops);
  }
  Result<bool> confirm(const StopRecord& stop, CellTime at) override {
    if (refuses_) return fail(ErrorCode::resource_exhausted, "DISK_FULL", "no room");
    return under_->stops().confirm(stop, at);
  }
  Result<std::vector<StopRecord>> pending() override { return under_->stops().pending(); }

  std::unique_ptr<Store> under_;
  int& keeps_;
  const bool& refuses_;
};

class StopDeskTest : public testing::Test {
 protected:
  tests::Folder folder;
  asio::io_context io;
  VirtualTime time{tests::kWorldBegin};
  VirtualClock clock{time};
  int keeps = 0;
  bool refuses = false;
  StoreWriter writer{io.get_executor(),
                     std::make_unique<StopsOnly>(
                         tests::kSqlite(folder / "cell.sqlite", false).value(), keeps, refuses)};
  EventLog events{io.get_executor(), clock, writer};
  TaskGroup tasks{io.get_executor()};
  Motor left, right;
  StopDesk desk{io.get_executor(),
                clock,
                writer,
                events,
                tasks,
                {controller("left", left), controller("right", right)}};

  ~StopDeskTest() override {
    desk.shut_down();
    until([this] { return tasks.count() == 0; });
    io.restart();
    io.poll();
  }
  StopDesk::Controller controller(const char* id, Motor& motor) {
    return {id, [this, &motor] { return stop(motor); }, [this, &motor] { return state(motor); }};
  }
  Awaitable<Result<void>> stop(Motor& motor) {
    ++motor.stops;
    co_await time.sleep_until(time.now().utc + std::chrono::milliseconds(1));
    if (motor.away) co_return fail(ErrorCode::unavailable, "LINK_DOWN", "no connection");
    co_return Result<void>{};
  }
  Awaitable<Result<MotionState>> state(Motor& motor) {
    ++motor.questions;
    co_await time.sleep_until(time.now().utc + std::chrono::milliseconds(1));
    if (motor.away) co_return fail(ErrorCode::unavailable, "LINK_DOWN", "no connection");
    co_return MotionState{time.now().utc, {0}, motor.moving, true, !motor.moving};
  }
  void until(const std::function<bool()>& condition) {
    const auto limit = time.now().utc + std::chrono::hours(1);
    while (!condition()) {
      io.restart();
      if (io.poll_one() > 0) continue;
      ASSERT_TRUE(time.step());
      ASSERT_LT(time.now().utc, limit);
    }
  }
  StopAnswer press() {
    std::optional<StopAnswer> answer;
    asio::co_spawn(io, desk.press({"ada", "peer", {}}, "stopped by ada"),
                   [&](std::exception_ptr, StopAnswer got) { answer = std::move(got); });
    until([&] { return answer.has_value(); });
    return *answer;
  }
};

TEST_F(StopDeskTest, IsConfirmedByTwoSuccessiveAnswersOfEveryController) {
  const auto answer = press();
  EXPECT_TRUE(answer.confirmed) << answer.message;
  EXPECT_GE(left.questions, 2);
  EXPECT_GE(right.questions, 2);
  EXPECT_TRUE(desk.check());
}

TEST_F(StopDeskTest, EveryControllerConfirmsForItself) {
  right.away = true;
  const auto answer = press();
  EXPECT_FALSE(answer.confirmed);
  ASSERT_EQ(answer.pending.size(), 1u);
  EXPECT_EQ(answer.pending.front().controller, "right");
  EXPECT_THAT(answer.message, HasSubstr("use the emergency switch"));
  EXPECT_THAT(answer.message, HasSubstr("no connection"));
  EXPECT_FALSE(desk.check());
  right.away = false;
  until([this] { return !desk.pending(); });
  until([this] { return desk.check().has_value(); });
}

TEST_F(StopDeskTest, IsSentAgainToAControllerThatGoesOnMoving) {
  left.moving = true;
  EXPECT_FALSE(press().confirmed);
  until([this] { return left.stops >= 3; });
  EXPECT_TRUE(desk.pending());
  left.moving = false;
  until([this] { return !desk.pending(); });
}

TEST_F(StopDeskTest, ASingleAnswerOfNoMotionBetweenTwoOfMotionEndsNothing) {
  left.moving = true;
  EXPECT_FALSE(press().confirmed);
  for (int i = 0; i < 20; ++i) {
    const int asked = left.questions;
    until([&] { return left.questions > asked; });
    left.moving = !left.moving;
  }
  EXPECT_TRUE(desk.pending());
}

// A finger, or a program, on the button: what each press costs the database and the controller.
TEST_F(StopDeskTest, ManyPressesShareTheWritesOfTheDatabase) {
  left.moving = true;
  for (int i = 0; i < 100; ++i)
    asio::co_spawn(io, desk.press({"ada", "peer", {}}, "stopped by ada"),
                   [](std::exception_ptr, const auto&) {});
  until([this] { return left.stops >= 100; });
  EXPECT_GE(right.stops, 100) << "each press is sent";
  EXPECT_LE(keeps, 10) << "one under way, and one for all that came meanwhile";
  left.moving = false;
  until([this] { return !desk.pending(); });
}

TEST_F(StopDeskTest, IsOverOnceItIsOnRecordToo) {
  refuses = true;
  const auto answer = press();
  EXPECT_TRUE(answer.confirmed) << "every controller rests";
  EXPECT_THAT(answer.message, HasSubstr("not on record yet: no room"));
  EXPECT_FALSE(desk.pending());
  ASSERT_FALSE(desk.check());
  EXPECT_THAT(desk.check().error().message, HasSubstr("reports no motion, but the stop is not on"));
  EXPECT_TRUE(desk.unstored());
  const int stops = left.stops;
  until([this, before = keeps] { return keeps > before + 3; });
  EXPECT_EQ(left.stops, stops) << "an axis that rests is left alone";
  refuses = false;
  until([this] { return desk.check().has_value(); });
  EXPECT_FALSE(desk.unstored());
}

TEST_F(StopDeskTest, OfAControllerThatTheCellNoLongerHasIsSentToAllOfThem) {
  StopRecord stop;
  stop.controller = "gone";
  stop.cause = "stopped by bob";
  stop.asked = clock.now();
  desk.restore({stop});
  EXPECT_TRUE(desk.pending());
  desk.start();
  until([this] { return !desk.pending(); });
  EXPECT_GE(left.stops, 1);
  EXPECT_GE(right.stops, 1);
}

}  // namespace
}  // namespace driftwise::application
