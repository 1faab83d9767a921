#pragma once
// driftwise configuration list | show | accept: the cell files that were in force.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_configuration_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
