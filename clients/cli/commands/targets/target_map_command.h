#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// target map --axis x --axis y=0:2.5:11 z=1: the correction over a plane of the workspace under the
// present conditions; moves nothing.
void add_target_map_command(CLI::App& target, Session& session);

}  // namespace driftwise::cli
