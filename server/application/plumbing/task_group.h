#pragma once
// The coroutines of the cell that nobody awaits: started here, counted here, awaited together at
// the end. One executor's thread only.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <exception>
#include <memory>
#include <utility>

#include "server/application/plumbing/signal.h"
#include "server/core/ports/awaitable.h"

namespace driftwise::application {

class TaskGroup {
 public:
  // Counts as a task while it lives: for work that somebody else awaits.
  class [[nodiscard]] Membership {
   public:
    explicit Membership(TaskGroup& group) : group_(&group) { group_->begin(); }
    Membership(Membership&& other) noexcept : group_(std::exchange(other.group_, nullptr)) {}
    Membership& operator=(Membership&&) = delete;
    ~Membership() {
      if (group_) group_->end();
    }

   private:
    TaskGroup* group_;
  };

  explicit TaskGroup(asio::any_io_executor executor)
      : executor_(std::move(executor)), ended_(executor_) {}

  // Starts a coroutine. It is a task of the group until it has ended and its frame is gone. An
  // exception is a bug: it leaves run() of the executor, and the process.
  void spawn(Awaitable<void> task) {
    begin();
    asio::co_spawn(executor_, std::move(task), [this](std::exception_ptr error) {
      end();
      if (error) std::rethrow_exception(error);
    });
  }
  Membership join() { return Membership(*this); }

  Awaitable<void> all_ended() {
    while (count_ > 0) co_await ended_.wait();
  }
  // False: some have not ended within this wall time.
  Awaitable<bool> all_ended_within(std::chrono::milliseconds limit) {
    asio::steady_timer timer(executor_, limit);
    const auto is_late = std::make_shared<bool>(false);  // the timer's handler may outlive the wait
    timer.async_wait([this, is_late](const boost::system::error_code& error) {
      if (!std::exchange(*is_late, true) && !error) ended_.raise();
    });
    while (count_ > 0 && !*is_late) co_await ended_.wait();
    *is_late = true;
    timer.cancel();
    co_return count_ == 0;
  }
  int count() const { return count_; }

 private:
  void begin() { ++count_; }
  void end() {
    if (--count_ == 0) ended_.raise();
  }

  asio::any_io_executor executor_;
  int count_ = 0;
  Signal ended_;
};

}  // namespace driftwise::application
