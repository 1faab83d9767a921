#pragma once
// Runs for people.

#include <string>
#include <vector>

#include "clients/cli/core/console.h"
#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

std::string state_text(v1::Run::State state);  // "running"
bool is_over(v1::Run::State state);

// "uncompensated", "compensated with model 3".
std::string compensation_text(const v1::Run& run);

// wanted: "key=value" that the runs were chosen by.
void print_runs(const Console& console, const std::vector<v1::Run>& runs,
                const std::vector<std::string>& wanted = {});
void print_run(const Console& console, const v1::Run& run);
// Of a run under way: what is ahead, and when it ends.
void print_ahead(const Console& console,
                 const v1::RunProgress& progress);  // one run, a line per fact

// done 0; aborted, failed 5.
ExitCode exit_code_of(v1::Run::State state);

}  // namespace driftwise::cli
