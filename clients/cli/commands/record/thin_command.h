#pragma once
// driftwise thin: raw readings of the environment become one row per device and interval.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_thin_command(CLI::App& app, Session& session);

}  // namespace driftwise::cli
