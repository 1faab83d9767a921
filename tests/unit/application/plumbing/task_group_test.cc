#include "server/application/plumbing/task_group.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <memory>
#include <stdexcept>
#include <utility>

#include "server/core/ports/spawn.h"

namespace driftwise::application {
namespace {

Awaitable<void> take_steps(int steps, std::shared_ptr<int> owned) {
  for (int i = 0; i < steps; ++i) co_await asio::post(asio::use_awaitable);
  ++*owned;
}

Awaitable<void> wait_for_all(TaskGroup& group, bool& ended) {
  co_await group.all_ended();
  ended = true;
}

TEST(TaskGroup, EndsWhenTheLastTaskHasEnded) {
  asio::io_context io;
  TaskGroup group(io.get_executor());
  const auto done = std::make_shared<int>(0);
  group.spawn(take_steps(3, done));
  group.spawn(take_steps(9, done));
  EXPECT_EQ(group.count(), 2);
  bool ended = false;
  spawn(io.get_executor(), wait_for_all(group, ended));
  io.run();
  EXPECT_TRUE(ended);
  EXPECT_EQ(group.count(), 0);
  EXPECT_EQ(*done, 2);
  EXPECT_EQ(done.use_count(), 1) << "the tasks' frames are gone";
}

TEST(TaskGroup, CountsAMembershipWhileItLives) {
  asio::io_context io;
  TaskGroup group(io.get_executor());
  bool ended = false;
  {
    const auto membership = group.join();
    spawn(io.get_executor(), wait_for_all(group, ended));
    io.poll();
    EXPECT_FALSE(ended);
  }
  io.run();
  EXPECT_TRUE(ended);
}

TEST(TaskGroup, LetsATasksExceptionLeaveTheExecutor) {
  asio::io_context io;
  TaskGroup group(io.get_executor());
  group.spawn([]() -> Awaitable<void> {
    co_await asio::post(asio::use_awaitable);
    throw std::logic_error("a bug");
  }());
  EXPECT_THROW(io.run(), std::logic_error);
  EXPECT_EQ(group.count(), 0);
}

}  // namespace
}  // namespace driftwise::application
