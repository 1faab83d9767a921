#pragma once
// A mutex for coroutines: lock() suspends where std::mutex would block. One executor's thread only.

#include <algorithm>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <deque>
#include <memory>
#include <utility>

#include "server/core/ports/awaitable.h"

namespace driftwise {

// Waiters get it in the order in which they came: a release hands it over to the first of them, so
// whoever releases it and locks it again stands behind everybody who waited. A waiter that is
// cancelled leaves the queue, or passes on what it was handed; the others keep their order.
class AsyncMutex {
  struct Waiter;
  struct State {
    bool locked = false;
    std::deque<Waiter*> waiters;  // first come, first

    void release();
  };

 public:
  // Holds the mutex; releases it at the end of its life.
  class [[nodiscard]] Lock {
   public:
    Lock(Lock&&) noexcept = default;
    Lock& operator=(Lock&&) = delete;
    ~Lock() {
      if (state_) state_->release();
    }

   private:
    friend class AsyncMutex;
    explicit Lock(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
  };

  explicit AsyncMutex(asio::any_io_executor executor) : executor_(std::move(executor)) {}

  Awaitable<Lock> lock() {
    const auto state = state_;
    if (!state->locked) {
      state->locked = true;
      co_return Lock(state);
    }
    Waiter waiter(executor_, state);
    while (!waiter.has_it)
      (void)co_await waiter.handed_over.async_wait(asio::as_tuple(asio::use_awaitable));
    waiter.has_it = false;  // the lock has it
    co_return Lock(state);
  }
  bool locked() const { return state_->locked; }

 private:
  // Lives in the frame of its coroutine, which may be unwound at any time.
  struct Waiter {
    Waiter(const asio::any_io_executor& executor, std::shared_ptr<State> mutex)
        : state(std::move(mutex)), handed_over(executor, asio::steady_timer::time_point::max()) {
      state->waiters.push_back(this);
    }
    Waiter(const Waiter&) = delete;
    ~Waiter() {
      std::erase(state->waiters, this);
      if (has_it) state->release();
    }

    std::shared_ptr<State> state;
    asio::steady_timer handed_over;
    bool has_it = false;
  };

  asio::any_io_executor executor_;
  // Held by locks and waiters too: a frame may be unwound after the mutex.
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

// Stays locked when somebody waits: nobody can come in between.
inline void AsyncMutex::State::release() {
  if (waiters.empty()) {
    locked = false;
    return;
  }
  Waiter* const next = waiters.front();
  waiters.pop_front();
  next->has_it = true;
  next->handed_over.cancel();
}

}  // namespace driftwise
