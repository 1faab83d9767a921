#pragma once

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <exception>
#include <optional>
#include <stdexcept>

#include "server/core/ports/awaitable.h"

namespace driftwise::tests {

// Runs the context until the work is done and returns its value. Throws when it is not done within
// the limit.
template <class T>
T run(asio::io_context& context, Awaitable<T> work,
      std::chrono::seconds limit = std::chrono::seconds(10)) {
  std::optional<T> value;
  std::exception_ptr thrown;
  asio::co_spawn(context, std::move(work), [&](std::exception_ptr error, T result) {
    if (error)
      thrown = error;
    else
      value.emplace(std::move(result));
  });
  context.restart();
  const auto until = std::chrono::steady_clock::now() + limit;
  while (!value && !thrown) {
    if (context.run_one_until(until) == 0)
      throw std::runtime_error("a coroutine of the test did not end");
  }
  if (thrown) std::rethrow_exception(thrown);
  return std::move(*value);
}

}  // namespace driftwise::tests
