#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// trajectory upload | list | show | generate: those kept in the daemon
void add_kept_trajectories(CLI::App& trajectory, Session& session);

}  // namespace driftwise::cli
