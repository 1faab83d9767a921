#pragma once
// driftwise whoami; driftwise token create | list | revoke.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_token_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
