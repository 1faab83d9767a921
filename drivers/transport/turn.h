#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/core/ports/awaitable.h"

namespace driftwise::transport {

// One conversation with a device at a time: calls that come meanwhile wait, first come first
// served. A device's stop takes its turn too, right after it has broken off the call that holds it.
// Executor's thread only.
class Turn {
 public:
  class Held {
   public:
    explicit Held(Turn& turn) : turn_(&turn) {}
    Held(Held&& other) noexcept : turn_(std::exchange(other.turn_, nullptr)) {}
    Held& operator=(Held&&) = delete;
    ~Held() {
      if (turn_) turn_->give_back();
    }

   private:
    Turn* turn_;
  };

  explicit Turn(asio::any_io_executor executor)
      : queue_(std::move(executor), asio::steady_timer::time_point::max()) {}

  Awaitable<Held> take() {
    while (taken_) (void)co_await queue_.async_wait(asio::as_tuple(asio::use_awaitable));
    taken_ = true;
    co_return Held(*this);
  }

 private:
  void give_back() {
    taken_ = false;
    queue_.cancel_one();
  }

  asio::steady_timer queue_;
  bool taken_ = false;
};

}  // namespace driftwise::transport
