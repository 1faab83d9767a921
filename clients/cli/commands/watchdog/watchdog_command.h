#pragma once

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// watchdog: takes signs of life of cells and raises the alarm when one falls silent.
void add_watchdog_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
