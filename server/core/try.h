#pragma once
// Macros that pass an error of a Result on to the caller, as Abseil's ASSIGN_OR_RETURN and
// RETURN_IF_ERROR do. The CO_ forms are for coroutines: they say co_return.
//
//   DRIFTWISE_TRY(const auto text, read_file(path));        // text: a value, not a Result
//   DRIFTWISE_CO_TRY(auto run, co_await std::move(reading));
//   DRIFTWISE_RETURN_IF_ERROR(check_options(options));      // for Result<void>
//
// A TRY declares its variable in the block where it stands, so it never is the single statement of
// an if. The expression may hold commas; the declaration may not. An expression that is a Result
// with a name is not copied by RETURN_IF_ERROR, so one that is needed afterwards can be checked
// too.

#include <tl/expected.hpp>
#include <utility>

#define DRIFTWISE_TRY(declaration, ...) \
  DRIFTWISE_TRY_BY(return, DRIFTWISE_UNIQUE_NAME(driftwise_result_), declaration, __VA_ARGS__)

#define DRIFTWISE_CO_TRY(declaration, ...) \
  DRIFTWISE_TRY_BY(co_return, DRIFTWISE_UNIQUE_NAME(driftwise_result_), declaration, __VA_ARGS__)

#define DRIFTWISE_RETURN_IF_ERROR(...) \
  DRIFTWISE_IF_ERROR_BY(return, DRIFTWISE_UNIQUE_NAME(driftwise_result_), __VA_ARGS__)

#define DRIFTWISE_CO_RETURN_IF_ERROR(...) \
  DRIFTWISE_IF_ERROR_BY(co_return, DRIFTWISE_UNIQUE_NAME(driftwise_result_), __VA_ARGS__)

// Implementation of the macros.
#define DRIFTWISE_TRY_BY(leave, result, declaration, ...)           \
  auto result = __VA_ARGS__;                                        \
  if (!result) leave ::tl::unexpected(::std::move(result).error()); \
  declaration = *::std::move(result)

// decltype(auto) with brackets: a name is referred to, anything else is held by value.
#define DRIFTWISE_IF_ERROR_BY(leave, result, ...)                                               \
  do {                                                                                          \
    if (decltype(auto) result = (__VA_ARGS__); !result) leave ::tl::unexpected(result.error()); \
  } while (false)

#define DRIFTWISE_UNIQUE_NAME(stem) DRIFTWISE_JOIN(stem, __LINE__)
#define DRIFTWISE_JOIN(a, b) DRIFTWISE_JOIN_NOW(a, b)
#define DRIFTWISE_JOIN_NOW(a, b) a##b
