#pragma once
// A trajectory held against the cell: `trajectory check`, and `run start` before it moves anything.

#include <string>

#include "clients/cli/core/connection.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {

// file: for messages. Throws Failure, 3 for a bad file and 5 for rows outside the limits.
v1::CheckTrajectoryResponse check_trajectory(const Connection& connection, const std::string& text,
                                             const std::string& file);
void print_check(const Console& console, const v1::CheckTrajectoryResponse& check,
                 const std::string& file);

}  // namespace driftwise::cli
