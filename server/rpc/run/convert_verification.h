#pragma once
// Verification of runs: domain -> proto.

#include <span>

#include "driftwise/v1/run_service.pb.h"
#include "server/core/records/records.h"
#include "server/diagnosis/check/verification.h"

namespace driftwise::rpc {

// runs: the records of those that were verified, in their order.
v1::VerifyRunsResponse verification_from(const diagnosis::Verification& verification,
                                         std::span<const RunRecord> runs);

}  // namespace driftwise::rpc
