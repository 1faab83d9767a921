#include "server/application/plumbing/signal.h"

#include <boost/asio/experimental/awaitable_operators.hpp>

namespace driftwise::application {

Awaitable<void> sleep_unless(Clock& clock, CellTime instant, Signal& signal) {
  using namespace asio::experimental::awaitable_operators;
  if (clock.now().utc >= instant) co_return;
  // Neither side throws, so that the operator has nothing to swallow.
  co_await (clock.sleep_until(instant) || signal.wait());
}

}  // namespace driftwise::application
