#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// model list | show | compare | promote | rollback | history | export
void add_model_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
