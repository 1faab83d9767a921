#pragma once
// `driftwise model check`: does the robot still do what a model says?

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_check_command(CLI::App& model, Session& session);  // below `model`

// Where a value stands between -limit and +limit, 21 characters: "|.....+....o.........|", with the
// mark at the edge when it is beyond.
std::string chart_line(double value, double limit);

}  // namespace driftwise::cli
