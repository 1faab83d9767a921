#pragma once
// CreateFit's request -> domain, with its checks. What only the data can tell (columns, ranks) is
// the fit's business.

#include "driftwise/v1/model_service.pb.h"
#include "server/application/models/fit_request.h"
#include "server/application/models/kinematic_record.h"
#include "server/core/result.h"

namespace driftwise::rpc {

constexpr std::size_t kMostRobotBytes = 256 * 1024;  // text of a robot file

enum class FormulaIs { required, optional };
enum class DataIs { required, optional };

// Errors: invalid_argument; RUNS_OR_CSV (both or neither), EMPTY_FORMULA, BAD_SELECT,
// BAD_PROBABILITY (outside ]0, 1[, or p_remove below p_enter: the regression could go in circles),
// BAD_CRITERION, BAD_OPTION (starts, seed, blocks, threads, too many terms), BAD_CURSOR, TOO_LONG
// and those of run_ids_from.
Result<application::FitRequest> fit_request_from(const v1::CreateFitRequest& request,
                                                 FormulaIs formula = FormulaIs::required,
                                                 DataIs data = DataIs::required);
// Errors: as fit_request_from, though formula and data may be missing; TOO_LONG.
Result<application::KinematicRequest> kinematic_request_from(
    const v1::CreateKinematicModelRequest& request);

}  // namespace driftwise::rpc
