#pragma once
// Coroutines of the stream sources (stream.h). An exception there is a bug of ours or a lack of
// memory: it ends the stream with an error, never the daemon.

#include <exception>
#include <memory>
#include <utility>

#include "server/core/ports/spawn.h"
#include "server/core/result.h"
#include "server/rpc/shared/error_mapping.h"

namespace driftwise::rpc {

// The result of the work, or the error that stands for its exception.
template <class T>
Awaitable<Result<T>> without_exception(Awaitable<Result<T>> work) {
  try {
    co_return co_await std::move(work);
  } catch (const std::exception& bug) {
    co_return tl::unexpected(error_of_exception(bug));
  }
}

template <class State>
Awaitable<void> run_for_source(Awaitable<void> task, std::shared_ptr<State> state) {
  try {
    co_await std::move(task);
  } catch (const std::exception& bug) {
    const Error error = error_of_exception(bug);
    if (!state->end) state->end = tl::unexpected(error);
    state->wake();
  }
}

// Starts a task of a source. state: what source and task share, with `end`
// (std::optional<Result<void>>) and `wake` (std::function<void()>).
template <class State>
void spawn_for_source(const asio::any_io_executor& executor, Awaitable<void> task,
                      std::shared_ptr<State> state) {
  spawn(executor, run_for_source(std::move(task), std::move(state)));
}

}  // namespace driftwise::rpc
