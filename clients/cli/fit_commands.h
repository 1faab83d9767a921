#pragma once
#include "clients/cli/session.h"

namespace driftwise::cli {

// fit FILE.csv --model FORMULA: here, without a daemon (fit_command.h).
// fit --run N [--run M] --model FORMULA: at the daemon, which stores the model.
void add_fit_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
