#pragma once
// The start of a coroutine that nobody awaits.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <exception>

#include "server/core/ports/awaitable.h"

namespace driftwise {

// An exception of the task is a bug: it leaves run() of the executor and ends the process.
inline void spawn(const asio::any_io_executor& executor, Awaitable<void> task) {
  asio::co_spawn(executor, std::move(task), [](std::exception_ptr error) {
    if (error) std::rethrow_exception(error);
  });
}

}  // namespace driftwise
