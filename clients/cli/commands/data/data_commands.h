#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// data export | import
void add_data_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
