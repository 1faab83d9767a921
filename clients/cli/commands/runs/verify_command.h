#pragma once
// run verify RUN [RUN...] [--model N]: what compensation achieved.

#include <CLI/CLI.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_verify_command(CLI::App& run, Session& session);

}  // namespace driftwise::cli
