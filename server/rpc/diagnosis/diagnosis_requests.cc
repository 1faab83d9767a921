#include <cmath>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {

Result<application::DiagnosisRequest> diagnosis_request_from(
    const v1::CreateDiagnosisRequest& request) {
  for (const auto& good : {check_size(request.csv(), kMostDatasetBytes, "csv"),
                           check_size(request.baseline(), kMostFormulaBytes, "baseline"),
                           check_size(request.name(), kMostNameBytes, "name"),
                           check_size(request.robot(), kMostNameBytes, "robot")})
    DRIFTWISE_RETURN_IF_ERROR(good);
  if (request.csv().empty() == request.run_ids().empty())
    return fail(ErrorCode::invalid_argument, reasons::kRunsOrCsv,
                std::string("found ") +
                    (request.csv().empty() ? "neither run_ids nor csv" : "run_ids and csv") +
                    ", expected one of them");
  application::DiagnosisRequest asked;
  DRIFTWISE_TRY(auto runs, run_ids_from(request.run_ids()));
  asked.runs = std::move(runs);
  asked.csv = request.csv();
  asked.baseline = request.baseline();
  asked.name = clean_line(request.name());
  asked.robot = request.robot();
  if (request.has_model_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(request.model_id(), "model_id"));
    asked.model = ModelId{request.model_id()};
  }
  if (request.has_alpha()) asked.alpha = request.alpha();
  if (!(asked.alpha > 0 && asked.alpha < 0.5))  // true for NaN
    return fail(
        ErrorCode::invalid_argument, reasons::kBadAlpha,
        "alpha: found " + formats::number_text(asked.alpha) + ", expected above 0 and below 0.5");
  if (request.has_seed()) asked.seed = request.seed();
  if (asked.seed < 0)
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "seed: found " + std::to_string(asked.seed) + ", expected a number from 0");
  for (const auto& symbol : request.exclude_symbols()) {
    DRIFTWISE_RETURN_IF_ERROR(check_size(symbol, kMostNameBytes, "exclude_symbols"));
    asked.exclude_symbols.push_back(symbol);
  }
  return asked;
}

Result<application::AcceptRequest> accept_request_from(const v1::AcceptExtensionRequest& request) {
  DRIFTWISE_RETURN_IF_ERROR(check_id(request.diagnosis_id(), "diagnosis_id"));
  application::AcceptRequest asked;
  asked.diagnosis = {request.diagnosis_id()};
  asked.promote = request.promote();
  asked.confirmed = request.confirmed();
  DRIFTWISE_TRY(auto reason, line_from(request.reason(), kMostNoteBytes, "reason"));
  if (reason.find_first_not_of(' ') != std::string::npos) asked.reason = std::move(reason);
  for (const std::int32_t number : request.finding_numbers()) {
    if (number < 1)
      return fail(ErrorCode::invalid_argument, reasons::kBadFinding,
                  "finding_numbers: found " + std::to_string(number) +
                      ", expected numbers from 1, as the diagnosis gives them");
    asked.findings.push_back(number);
  }
  return asked;
}

Result<application::ImproveRequest> improve_request_from(
    const v1::CreateImprovementRequest& request) {
  for (const auto& good :
       {check_size(request.trajectory_name(), kMostNameBytes, "trajectory_name"),
        check_size(request.setup(), kMostNameBytes, "setup"),
        check_size(request.robot(), kMostNameBytes, "robot"),
        check_size(request.trajectory_text(), kMostTrajectoryBytes, "trajectory_text"),
        check_size(request.formula(), kMostFormulaBytes, "formula"),
        check_size(request.request_id(), kMostRequestIdBytes, "request_id"),
        check_size(request.lease_token(), kMostNameBytes, "lease_token")})
    DRIFTWISE_RETURN_IF_ERROR(good);
  if (request.trajectory_text().empty())
    return fail(ErrorCode::invalid_argument, reasons::kEmptyTrajectory,
                "trajectory_text: found nothing, expected a CSV file");
  if (!(request.budget_s() >= 0 && request.budget_s() <= kMostAsked_s))
    return fail(ErrorCode::invalid_argument, reasons::kBadBudget,
                "budget_s: found " + formats::number_text(request.budget_s()) +
                    ", expected 0 (no limit) or seconds of cell time");
  if (request.max_turns() < 0)
    return fail(ErrorCode::invalid_argument, reasons::kBadTurns,
                "max_turns: found " + std::to_string(request.max_turns()) +
                    ", expected 0 (meaning 5) or more");
  application::ImproveRequest asked;
  asked.lease_token = request.lease_token();
  asked.trajectory_name =
      request.trajectory_name().empty() ? "trajectory" : clean_line(request.trajectory_name());
  asked.trajectory_text = request.trajectory_text();
  asked.formula = request.formula();
  if (request.max_turns() > 0) asked.max_turns = request.max_turns();
  asked.budget_s = request.budget_s();
  asked.promotes = request.promote();
  asked.setup = clean_line(request.setup());
  asked.robot = request.robot();
  asked.request_id = request.request_id();
  return asked;
}

}  // namespace driftwise::rpc
