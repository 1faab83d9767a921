#pragma once
#include <cstdint>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// What a run measured, as tables or JSON.
ExitCode show_points(const Session& session, std::int64_t run_id);
ExitCode show_attempts(const Session& session, std::int64_t run_id);
ExitCode show_datums(const Session& session, std::int64_t run_id);

}  // namespace driftwise::cli
