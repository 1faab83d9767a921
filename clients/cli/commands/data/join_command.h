#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// "data join": stored runs, or dataset files without a daemon.
void add_join_command(CLI::App& data, Session& session);

}  // namespace driftwise::cli
