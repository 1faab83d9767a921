#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// plan add | list | show | check | promote | rollback | target
void add_plan_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
