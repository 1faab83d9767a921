#pragma once
// A signal between coroutines of the executor's thread. It belongs to that thread and needs no
// mutex.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/core/ports/awaitable.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

// Whoever waits resumes at the next raise(). Nothing is remembered: look at your condition first,
// then wait.
class Signal {
 public:
  explicit Signal(const asio::any_io_executor& executor)
      : timer_(executor, asio::steady_timer::time_point::max()) {}
  void raise() { timer_.cancel(); }
  // Also resumes when the waiting coroutine is cancelled.
  Awaitable<void> wait() { co_await timer_.async_wait(asio::as_tuple(asio::use_awaitable)); }

 private:
  asio::steady_timer timer_;
};

// Sleeps until the instant or until the signal is raised, whichever comes first.
Awaitable<void> sleep_unless(Clock& clock, CellTime instant, Signal& signal);

}  // namespace driftwise::application
