#pragma once
#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// procedure: steps 0 to 5 of the study on one page (procedure_steps.h), from the daemon's record.
// Exit code 1: a wanted accuracy is not reached.
void add_procedure_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
