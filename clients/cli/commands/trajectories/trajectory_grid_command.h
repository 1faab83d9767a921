#pragma once

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// `trajectory grid`: makes a plan out of blocks. Works without a daemon.
void add_trajectory_grid(CLI::App& trajectory, Session& session);

// `trajectory sigma6`: the predecessors' six-axis robot, its plan, hours and kinematics.
void add_sigma6_command(CLI::App& trajectory, Session& session);

}  // namespace driftwise::cli
