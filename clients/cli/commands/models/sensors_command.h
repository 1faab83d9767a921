#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// model sensors FILE.csv --model FORMULA, or --run N: which thermometers suffice, and what each
// fewer costs. Worked out here from the file, or at the daemon from its runs.
void add_sensors_command(CLI::App& model, Session& session);

}  // namespace driftwise::cli
