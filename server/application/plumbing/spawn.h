#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <exception>

#include "server/core/ports/awaitable.h"

namespace driftwise::application {

// Starts a coroutine that nobody waits for. An exception is a bug: it leaves run() of the executor,
// and the process.
inline void spawn(const asio::any_io_executor& executor, Awaitable<void> task) {
  asio::co_spawn(executor, std::move(task), [](std::exception_ptr error) {
    if (error) std::rethrow_exception(error);
  });
}

}  // namespace driftwise::application
