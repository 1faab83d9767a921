#pragma once
#include <cstdint>

#include "clients/cli/core/session.h"
#include "driftwise/v1/run_service.pb.h"

namespace driftwise::cli {

// What a run measured, as tables or JSON.
ExitCode show_points(const Session& session, std::int64_t run_id);
ExitCode show_attempts(const Session& session, std::int64_t run_id);
// With the returns to zero, as they were judged.
ExitCode show_datums(const Session& session, std::int64_t run_id);

v1::ListClosuresResponse closures_of_run(const Connection& connection, std::int64_t run_id);
// Counts by decision, and the sentence of each that was beyond its limit.
void print_closure_summary(const Console& console, const v1::ListClosuresResponse& closures);
std::string decision_text(v1::Closure::Decision decision);

}  // namespace driftwise::cli
