#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// improve PLAN.csv: measure, fit, diagnose, extend, measure again, by the daemon; improve list,
// show, cancel.
void add_improve_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
