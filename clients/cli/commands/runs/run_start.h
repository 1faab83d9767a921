#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// run start FILE [--name] [--compensate [--model N]] [--watch] [--dry-run]
void add_run_start(CLI::App& run, Session& session);

}  // namespace driftwise::cli
