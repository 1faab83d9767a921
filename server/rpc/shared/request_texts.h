#pragma once
// Length of every text that a client sends, checked by the guard for all rpcs alike.

#include <google/protobuf/message.h>

#include <algorithm>
#include <cstddef>

#include "server/core/result.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {

// A text of a request is stored, logged or repeated in an error: at most this much, in every field.
constexpr std::size_t kMostTextBytes = std::max(kMostNoteBytes, kMostFormulaBytes);
constexpr std::size_t kMostTextsBytes = 1024 * 1024;  // of one request, all texts together

// Texts of the request, those of nested messages too, keep both limits. Whole files (fields such as
// trajectory_text) and bytes count for neither: the rpc that takes one has a limit for it. Errors:
// invalid_argument TOO_LONG, naming the field ("answer.override_reason", "metadata[2].value") and
// the size found.
Result<void> check_texts(const google::protobuf::Message& request);

}  // namespace driftwise::rpc
