#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// alarms [--all], alarms acknowledge, shelve, unshelve; notify list, notify test
void add_alarm_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
