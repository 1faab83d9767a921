#pragma once
// driftwise backup | restore: a verified copy of the record while the cell works, and its way back.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_backup_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
