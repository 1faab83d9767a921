#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// formula check FORMULA (--run N | FILE.csv): what a formula offers on these data and what of it
// they can tell apart, asked of the daemon. Fits nothing. Exit code 1: it cannot be fitted.
void add_formula_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
