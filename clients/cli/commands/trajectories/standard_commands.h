#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// standard iso230-2 | iso230-3 | iso9283, of a run at the daemon or of a dataset CSV
void add_standard_commands(CLI::App& app, Session& session);
// trajectory iso230-2 | iso230-3 | iso9283: what a run needs so that its figures can be had
void add_standard_trajectories(CLI::App& trajectory, Session& session);

}  // namespace driftwise::cli
