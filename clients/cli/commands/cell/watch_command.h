#pragma once
// `driftwise watch`: the cell, live in the terminal.

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_watch_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
