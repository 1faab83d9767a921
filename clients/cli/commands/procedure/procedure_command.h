#pragma once
#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// procedure: steps 0 to 5 of the study, as the daemon computes them from its record. Exit code 1: a
// wanted accuracy is not reached.
void add_procedure_command(CLI::App& app, Session& session);

// design: U90 of a model's targets with other instruments, lever arms or material.
void add_design_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
