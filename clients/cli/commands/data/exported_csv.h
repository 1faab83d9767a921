#pragma once
#include <string>
#include <vector>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

// The dataset of runs as the daemon exports it: CSV text, whole.
std::string exported_csv(const Session& session, const std::vector<std::int64_t>& runs,
                         bool without_excluded);

}  // namespace driftwise::cli
