#pragma once
#include "clients/cli/core/session.h"
#include "driftwise/v1/target_service.pb.h"

namespace driftwise::cli {

// target x=1.5 [--budget] [--watch]
void add_target_command(CLI::App& app, Session& session);

// For people: a table of coordinates, what the model adds in nm, uncertainty, then flags.
void print_target(const Console& console, const v1::ComputeTargetRequest& request,
                  const v1::Target& target);

// One line for each flag, with the channels that it is about.
void print_flags(const Console& console, const v1::Target& target);

}  // namespace driftwise::cli
