#pragma once
// Following a run to its end: a bar on standard error, or one JSON object per line with --json.

#include <cstdint>
#include <optional>

#include "clients/cli/core/session.h"
#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

// run_id: none for the one under way. Returns the run as last seen, which is over. Throws Failure;
// when interrupted or out of time the run goes on, and the message says how to look again or end
// it.
v1::Run watch_until_over(const Session& session, const Connection& connection,
                         std::optional<std::int64_t> run_id);

}  // namespace driftwise::cli
