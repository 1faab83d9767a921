#pragma once
// What the world can do to us, as values. Bugs and failed start-up throw instead.

#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driftwise {

// Named after the gRPC codes they become, so that one function in server/rpc maps them.
enum class ErrorCode {
  invalid_argument,     // bad input: file, line, field, found, expected
  not_found,            // no such run, model, channel
  already_exists,       // same id or request twice with other content
  failed_precondition,  // right request, wrong state: say which state and what to do
  aborted,              // stopped by a person or by a safety rule
  out_of_range,         // outside soft limits or the fitted domain
  resource_exhausted,   // full disk, full queue
  unavailable,          // a device or the daemon cannot be reached
  deadline_exceeded,    // no answer in time
  data_loss,            // what was stored or received is damaged
  permission_denied,    // somebody else holds the lease, or the role is too low
  unauthenticated,      // nobody has said who asks, or nobody believes it
  cancelled,
  internal,  // a bug of ours
};

// reason: for programs, UPPER_SNAKE_CASE and stable ("RANK_DEFICIENT"). message: for people; says
// what was asked, what was found, where, and what to do.
struct Error {
  ErrorCode code;
  std::string reason;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string reason, std::string message) {
  return tl::unexpected(Error{code, std::move(reason), std::move(message)});
}

// "invalid_argument" and so on: what logs and --json print.
std::string_view to_string(ErrorCode code);

}  // namespace driftwise
