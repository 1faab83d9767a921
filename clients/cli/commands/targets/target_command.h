#pragma once
#include "clients/cli/core/session.h"
#include "driftwise/v1/target_service.pb.h"

namespace driftwise::cli {

// target x=1.5 [--budget] [--watch]
void add_target_command(CLI::App& app, Session& session);

// One line for each flag, with the channels that it is about.
void print_flags(const Console& console, const v1::Target& target);

}  // namespace driftwise::cli
