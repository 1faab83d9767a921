#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// queue add | list | show | edit | move | remove | hold | release | history
void add_queue_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
