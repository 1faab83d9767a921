#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// hold | hold aside NAME | hold restore NAME
void add_hold_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
