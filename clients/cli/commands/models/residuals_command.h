#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// model residuals N [--run M | FILE.csv] [-o FILE]: what a model leaves unexplained, row by row,
// with the channels that it may go with, as dataset CSV; in a few lines what they come to.
void add_residuals_command(CLI::App& model, Session& session);

}  // namespace driftwise::cli
