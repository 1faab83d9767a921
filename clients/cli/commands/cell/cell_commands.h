#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// status, devices, events, readings
void add_status_commands(CLI::App& app, Session& session);
// stop, home, move, stabiliser, lease show | take | give-up
void add_motion_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
