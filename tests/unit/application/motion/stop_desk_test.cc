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

class StopDeskTest : public testing::Test {
 protected:
  tests::Folder folder;
  asio::io_context io;
  VirtualTime time{tests::kWorldBegin};
  VirtualClock clock{time};
  StoreWriter writer{io.get_executor(), tests::kSqlite(folder / "cell.sqlite", false).value()};
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
    asio::co_spawn(io, desk.press({"ada", "peer"}, "stopped by ada"),
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
  EXPECT_TRUE(desk.check());
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
