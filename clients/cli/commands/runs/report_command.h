#pragma once
#include "clients/cli/core/session.h"

namespace driftwise::cli {

// report run N -o run.html
void add_report_command(CLI::App& app, Session& session);

// The report of a run, made by the daemon now, into a file. entry: of the queue, for the words; 0:
// none.
ExitCode save_report(const Session& session, std::int64_t run, std::int64_t entry,
                     const std::string& file);

}  // namespace driftwise::cli
