#pragma once
// `driftwise completion` and `driftwise man`: what the program says of itself, in other programs'
// formats. Added last, for they describe all the others.

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_manual_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
