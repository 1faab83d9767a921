#pragma once
// driftwise open.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_open_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
