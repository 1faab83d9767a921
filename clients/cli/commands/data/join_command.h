#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// "data join": stored runs, or dataset files without a daemon.
void add_join_command(CLI::App& data, Session& session);

// "data instruments": a second instrument or a measured work-piece on the points of a run.
void add_instruments_command(CLI::App& data, Session& session);

// "data angle-drift": of a rotation's reading with a temperature, on a dataset file.
void add_angle_drift_command(CLI::App& data, Session& session);

}  // namespace driftwise::cli
