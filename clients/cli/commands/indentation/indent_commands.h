#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// indent start | show | import | table
void add_indent_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
