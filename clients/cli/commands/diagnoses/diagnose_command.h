#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// diagnose FILE.csv --baseline FORMULA: what the simulation gets wrong, here, without a daemon;
// diagnose --run N: there, stored (diagnosis_commands.h).
// Exit code 1 when structure remains that no cause explains.
void add_diagnose_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
