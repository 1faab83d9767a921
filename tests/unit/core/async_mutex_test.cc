#include "server/core/ports/async_mutex.h"

#include <gmock/gmock.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/io_context.hpp>
#include <memory>
#include <optional>
#include <string>

#include "server/core/ports/spawn.h"

namespace driftwise {
namespace {

class AsyncMutexTest : public testing::Test {
 protected:
  // Locks, notes its name, and holds the lock for so many further steps of the executor.
  Awaitable<void> hold(std::string name, int steps) {
    const auto lock = co_await mutex.lock();
    order += name + "(";
    for (int i = 0; i < steps; ++i) co_await asio::post(asio::use_awaitable);
    order += ")";
  }

  asio::io_context io;
  AsyncMutex mutex{io.get_executor()};
  std::string order;
};

TEST_F(AsyncMutexTest, LetsOneInAtATimeInTheOrderOfTheCalls) {
  for (const char* name : {"a", "b", "c", "d"}) spawn(io.get_executor(), hold(name, 3));
  io.run();
  EXPECT_EQ(order, "a()b()c()d()");
  EXPECT_FALSE(mutex.locked());
}

TEST_F(AsyncMutexTest, StaysLockedWhileALockLives) {
  std::optional<AsyncMutex::Lock> kept;
  spawn(io.get_executor(),
        [](AsyncMutex& one, std::optional<AsyncMutex::Lock>& to) -> Awaitable<void> {
          to.emplace(co_await one.lock());
        }(mutex, kept));
  spawn(io.get_executor(), hold("a", 0));
  io.run_one();
  io.poll();
  EXPECT_TRUE(mutex.locked());
  EXPECT_EQ(order, "");
  kept.reset();
  io.run();
  EXPECT_EQ(order, "a()");
}

TEST_F(AsyncMutexTest, GoesToTheNextWhenAWaiterIsCancelled) {
  asio::cancellation_signal cancel;
  spawn(io.get_executor(), hold("a", 5));
  bool cancelled = false;
  asio::co_spawn(io, hold("b", 0),
                 asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr error) {
                   cancelled = error != nullptr;
                 }));
  spawn(io.get_executor(), hold("c", 0));
  asio::post(io, [&] { cancel.emit(asio::cancellation_type::terminal); });
  io.run();
  EXPECT_TRUE(cancelled);
  EXPECT_EQ(order, "a()c()");
  EXPECT_FALSE(mutex.locked());
}

TEST_F(AsyncMutexTest, IsNotOvertakenByWhoeverReleasesItAndLocksItAgain) {
  const auto again_and_again = [](AsyncMutex& one, std::string& into) -> Awaitable<void> {
    for (int i = 0; i < 5; ++i) {
      const auto lock = co_await one.lock();
      into += "a";
      co_await asio::post(asio::use_awaitable);
    }
  };
  spawn(io.get_executor(), again_and_again(mutex, order));
  spawn(io.get_executor(), hold("b", 0));
  io.run();
  EXPECT_EQ(order, "ab()aaaa");
}

TEST_F(AsyncMutexTest, IsPassedOnByAWaiterThatIsCancelledAfterItWasHandedOver) {
  asio::cancellation_signal cancel;
  std::optional<AsyncMutex::Lock> kept;
  spawn(io.get_executor(),
        [](AsyncMutex& one, std::optional<AsyncMutex::Lock>& to) -> Awaitable<void> {
          to.emplace(co_await one.lock());
        }(mutex, kept));
  asio::co_spawn(io, hold("b", 1),
                 asio::bind_cancellation_slot(cancel.slot(), [](std::exception_ptr) {}));
  spawn(io.get_executor(), hold("c", 0));
  io.poll();
  kept.reset();
  cancel.emit(asio::cancellation_type::terminal);  // b was woken and has not run yet
  io.restart();
  io.run();
  EXPECT_THAT(order, testing::EndsWith("c()"));
  EXPECT_FALSE(mutex.locked());
}

TEST_F(AsyncMutexTest, MayGoBeforeItsWaiters) {
  auto context = std::make_unique<asio::io_context>();
  auto one = std::make_unique<AsyncMutex>(context->get_executor());
  const auto wait_for = [](AsyncMutex& waited_for) -> Awaitable<void> {
    const auto lock = co_await waited_for.lock();
    co_await asio::steady_timer(co_await asio::this_coro::executor,
                                asio::steady_timer::time_point::max())
        .async_wait(asio::use_awaitable);
  };
  for (int i = 0; i < 3; ++i) spawn(context->get_executor(), wait_for(*one));
  context->poll();
  one.reset();
  context.reset();  // unwinds the holder and both waiters
}

}  // namespace
}  // namespace driftwise
