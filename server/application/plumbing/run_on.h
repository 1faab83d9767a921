#pragma once
// The hop to another thread and back, for work that would block the executor.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>

#include "server/core/ports/awaitable.h"

namespace driftwise::application {

namespace detail {
template <class Function, class... Owned>
struct SharedCall {
  Function function;
  std::tuple<Owned...> arguments;
};

template <class Function, class... Owned>
Awaitable<std::invoke_result_t<Function&, Owned&...>> call_shared(
    std::shared_ptr<SharedCall<Function, Owned...>> call) {
  co_return std::apply(call->function, call->arguments);
}
}  // namespace detail

// Runs a plain function on another thread's executor and comes back with its result. An exception
// comes back as an exception. The arguments are copied, or moved where they are given by std::move,
// and belong to the call: the function gets them as variables that nobody else knows.
//
//   co_await run_on(worker, fit_on, request, std::move(dataset));
//
// GCC 12 copies a closure that is written inside a co_await expression bit by bit, which breaks
// what points into itself (short strings). So a closure may hold numbers, pointers and references
// only, which the compiler checks; what owns memory is an argument.
template <class Function, class... Arguments>
Awaitable<std::invoke_result_t<Function&, std::decay_t<Arguments>&...>> run_on(
    asio::any_io_executor where, Function function, Arguments&&... arguments) {
  static_assert(std::is_trivially_copyable_v<Function>,
                "the closure owns something: give it as an argument of run_on");
  using Call = detail::SharedCall<Function, std::decay_t<Arguments>...>;
  auto call = std::make_shared<Call>(Call{
      function, std::tuple<std::decay_t<Arguments>...>(std::forward<Arguments>(arguments)...)});
  return asio::co_spawn(std::move(where), detail::call_shared(std::move(call)),
                        asio::use_awaitable);
}

}  // namespace driftwise::application
