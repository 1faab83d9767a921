#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// channel allan, channel spectrum
void add_channel_commands(CLI::App& app, Session& session);
// run compare
void add_compare_command(CLI::App& run, Session& session);
// note pin, note pinned
void add_time_note_commands(CLI::App& note, Session& session);

}  // namespace driftwise::cli
