#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// run start | list | show | watch | pause | resume | abort | points | attempts | datums
void add_run_commands(CLI::App& app, Session& session);
// trajectory check
void add_trajectory_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
