#pragma once
#include <cstdint>
#include <vector>

#include "clients/cli/commands/models/fit_command.h"
#include "clients/cli/core/session.h"
#include "driftwise/v1/model_service.pb.h"

namespace driftwise::cli {

// fit FILE.csv --model FORMULA: here, without a daemon (fit_command.h).
// fit --run N [--run M] --model FORMULA: at the daemon, which stores the model.
void add_fit_command(CLI::App& app, Session& session);

// The same options for the daemon's fit of runs. Throws Failure (usage) for one that works on a
// file only, naming what does its work there.
v1::CreateFitRequest fit_request_of(const FitOfFile& fit, const std::vector<std::int64_t>& runs);

}  // namespace driftwise::cli
