#pragma once
// The domain's results in the client: a value, or a Failure that ends the command with exit code 3.

#include <string>
#include <utility>

#include "clients/cli/core/console.h"
#include "server/core/result.h"

namespace driftwise::cli {

inline Failure failure_of(const Error& error) {
  return {ExitCode::bad_input, std::string(to_string(error.code)), error.reason, error.message};
}

template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw failure_of(result.error());
  return std::move(*result);
}

}  // namespace driftwise::cli
