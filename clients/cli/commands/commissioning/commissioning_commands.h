#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// cell check, cell certificates
void add_cell_check_commands(CLI::App& app, Session& session);
// jog
void add_jog_command(CLI::App& app, Session& session);
// align, align thermometers, align rest
void add_align_commands(CLI::App& app, Session& session);
// support bundle
void add_support_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
