#pragma once
// The text protocol for controllers without gRPC: one line asks, one line answers. Codec only; the
// socket is server/line/target_line_server. Manual with examples: docs/target-line.md.
//
//   TARGET x_mm=1.5 u=1
//   OK q1_mm=1.500123456 u90_nm=8.1 valid_until=2026-11-21T08:05:04Z model=3 flags=-
//   ERR OUTSIDE_DOMAIN x_mm outside what the model was fitted on, ...

#include <string>
#include <string_view>

#include "server/compensation/target.h"
#include "server/core/result.h"

namespace driftwise::formats {

constexpr std::size_t kMaxTargetLine =
    512;  // bytes of a request with its end; a longer one ends the connection

// line: without its end (LF or CRLF). Words are parted by blanks; names are exact, their order is
// free. Errors, invalid_argument: LINE_TOO_LONG, UNKNOWN_VERB, BAD_WORD (no name=value),
// UNKNOWN_NAME, DUPLICATE_NAME, BAD_NUMBER, BAD_FLAG (u is 0 or 1).
Result<compensation::TargetRequest> parse_target_line(std::string_view line);

// Appends the answer with its LF: nothing is allocated once out has the room (kMaxTargetAnswer is
// enough for one axis). The numbers of q read back exactly.
void append_target_answer(std::string& out, const compensation::Snapshot& snapshot,
                          const compensation::Target& target, bool with_uncertainty);
void append_error_answer(std::string& out, const Error& error);
constexpr std::size_t kMaxTargetAnswer = 4096;

}  // namespace driftwise::formats
