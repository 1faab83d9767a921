#include "server/rpc/run/create_run_request.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {

Result<application::CreateRun> create_run_from(const v1::CreateRunRequest& request,
                                               const RunRules& cell_rules) {
  for (const auto& good :
       {check_size(request.name(), kMostNameBytes, "name"),
        check_size(request.trajectory_name(), kMostNameBytes, "trajectory_name"),
        check_size(request.request_id(), kMostRequestIdBytes, "request_id"),
        check_size(request.lease_token(), kMostNameBytes, "lease_token"),
        check_size(request.setup(), kMostNameBytes, "setup"),
        check_size(request.trajectory_text(), kMostTrajectoryBytes, "trajectory_text")})
    DRIFTWISE_RETURN_IF_ERROR(good);
  if (request.trajectory_text().empty())
    return fail(ErrorCode::invalid_argument, reasons::kEmptyTrajectory,
                "trajectory_text: found nothing, expected a CSV file");

  application::CreateRun asked;
  asked.name = clean_line(request.name());
  asked.trajectory_name = clean_line(request.trajectory_name());
  asked.trajectory_text = request.trajectory_text();
  asked.request_id = request.request_id();
  asked.lease_token = request.lease_token();
  asked.setup = request.setup();
  asked.compensate = request.compensate();
  asked.validate_only = request.validate_only();
  DRIFTWISE_TRY(asked.metadata, metadata_from(request.metadata()));
  if (request.has_rules()) {
    DRIFTWISE_TRY(auto rules, rules_from(request.rules(), cell_rules));
    asked.rules = rules;
  }
  if (request.has_compensate_model_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(request.compensate_model_id(), "compensate_model_id"));
    if (!request.compensate())
      return fail(ErrorCode::invalid_argument, reasons::kModelWithoutCompensate,
                  "compensate_model_id names a model, but compensate is not set");
    asked.compensate_with = ModelId{request.compensate_model_id()};
  }
  return asked;
}

v1::CheckTrajectoryResponse check_response_from(const application::TrajectoryCheck& check) {
  v1::CheckTrajectoryResponse out;
  out.set_row_count(static_cast<std::int64_t>(check.trajectory.points.size()));
  out.set_calibration_count(check.calibration);
  out.set_validation_count(check.validation);
  out.set_zero_count(check.zeros);
  out.set_line_count(check.lines);
  for (const auto& coordinate : check.trajectory.coordinates)
    out.add_coordinates(coordinate.name());
  *out.mutable_estimated_duration() = duration_from_s(check.estimated_s);
  *out.mutable_estimated_band() = band_from(check.outlook);
  for (const auto& warning : check.warnings) out.add_warnings(utf8_from(warning));
  return out;
}

}  // namespace driftwise::rpc
