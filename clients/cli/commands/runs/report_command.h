#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// report run N -o run.html
void add_report_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
