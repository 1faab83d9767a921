#pragma once
// Age of what a client knew of the cell when it sent a call that moves something. A line that
// stalls keeps such a call and delivers it when nobody looks at the machine any more.
//
// The client states the daemon's own time as it heard it last, so no clocks are compared.

#include <chrono>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::rpc {

// Metadata of a call: server_time of the last WatchResponse, Unix time in ms. Absent: not judged.
inline constexpr const char* kHeardKey = "driftwise-heard-ms";

// path: "/driftwise.v1.CellService/Move"; the limit is the rpc's option heard_within_ms, without
// one any age is good. Errors: failed_precondition ASKED_LONG_AGO; invalid_argument BAD_METADATA.
Result<void> heard_recently(std::string_view path, std::string_view heard_ms,
                            std::chrono::system_clock::time_point now);

}  // namespace driftwise::rpc
