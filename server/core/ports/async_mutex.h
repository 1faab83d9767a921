#pragma once
// A mutex for coroutines: lock() suspends where std::mutex would block. One executor's thread only.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "server/core/ports/awaitable.h"

namespace driftwise {

// Waiters get it in the order in which they came. A waiter that is cancelled leaves the queue; the
// others keep their order.
class AsyncMutex {
 public:
  // Holds the mutex; releases it at the end of its life. The mutex outlives it.
  class [[nodiscard]] Lock {
   public:
    Lock(Lock&& other) noexcept : mutex_(std::exchange(other.mutex_, nullptr)) {}
    Lock& operator=(Lock&&) = delete;
    ~Lock() {
      if (mutex_) mutex_->release();
    }

   private:
    friend class AsyncMutex;
    explicit Lock(AsyncMutex& mutex) : mutex_(&mutex) {}
    AsyncMutex* mutex_;
  };

  explicit AsyncMutex(const asio::any_io_executor& executor)
      : released_(executor, asio::steady_timer::time_point::max()) {}

  Awaitable<Lock> lock() {
    while (locked_) (void)co_await released_.async_wait(asio::as_tuple(asio::use_awaitable));
    locked_ = true;
    co_return Lock(*this);
  }
  bool locked() const { return locked_; }

 private:
  // Wakes every waiter: the first takes the mutex, the others queue again in their order. Waking
  // one only would lose the mutex where that one is cancelled before it runs.
  void release() {
    locked_ = false;
    released_.cancel();
  }

  asio::steady_timer released_;
  bool locked_ = false;
};

}  // namespace driftwise
