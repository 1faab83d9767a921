#pragma once
// driftwise audit list | head | verify: who did what, and whether the record was changed since; of
// a daemon, or of a database file without one.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_audit_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
