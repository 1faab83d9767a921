#pragma once
#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// model grow: climbs the ladder of terms until held-out prediction stops improving (ladder.h).
// model points: how many points buy how many nm (learning_curve.h).
// model table: formulas by named sets by outputs (set_table.h).
// Each of a dataset file, or with --run of runs as the daemon exports them; computed here.
void add_grow_command(CLI::App& model, Session& session);
void add_points_command(CLI::App& model, Session& session);
void add_table_command(CLI::App& model, Session& session);

}  // namespace driftwise::cli
