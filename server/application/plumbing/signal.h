#pragma once
// The waiting tools of the executor's thread: a signal, and a hop to another thread. Everything here
// belongs to one thread and needs no mutex.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <memory>
#include <type_traits>
#include <utility>

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

namespace detail {
template <class Function>
Awaitable<std::invoke_result_t<Function&>> call_shared(std::shared_ptr<Function> function) {
  co_return (*function)();
}
}  // namespace detail

// Runs a plain function on another thread's executor and comes back with its result. The function
// owns what it uses. An exception comes back as an exception.
//
// GCC 12 moves a closure that is written inside a co_await expression bit by bit, which breaks what
// points into itself (short strings). This is an ordinary function for that reason, and a caller
// whose closure owns more than numbers and pointers writes two statements:
//   auto storing = writer.call([event](Store& store) { ... });
//   auto stored = co_await std::move(storing);
// The same goes for a?b:c that makes a string there.
template <class Function>
Awaitable<std::invoke_result_t<Function&>> run_on(asio::any_io_executor where, Function function) {
  return asio::co_spawn(where, detail::call_shared(std::make_shared<Function>(std::move(function))),
                        asio::use_awaitable);
}

}  // namespace driftwise::application
