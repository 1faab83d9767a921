#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// simulate [q1=1.5 ...] [force=0.3 ...]: where the end-effector is, and what an instrument reads
// beside it; moves nothing.
void add_simulate_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
