#include "server/rpc/data/join_request.h"

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {
namespace {

Result<void> check_positive(double value, const std::string& field) {
  if (value > 0 && value <= 1e6) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadLimit,
              field + ": found " + number_text(value) + ", expected a positive number");
}

}  // namespace

Result<application::JoinRequest> join_from(const v1::JoinRunsRequest& request) {
  application::JoinRequest out;
  DRIFTWISE_TRY(out.runs, run_ids_from(request.run_ids()));
  DRIFTWISE_TRY(out.name, line_from(request.name(), kMostNameBytes, "name"));
  DRIFTWISE_RETURN_IF_ERROR(check_size(request.request_id(), kMostRequestIdBytes, "request_id"));
  out.request_id = request.request_id();
  out.dry_run = request.dry_run();
  out.rules.subtract_returns = request.subtract_returns();
  if (request.has_max_temperature_difference_k()) {
    out.rules.max_temperature_difference_k = request.max_temperature_difference_k();
    DRIFTWISE_RETURN_IF_ERROR(
        check_positive(out.rules.max_temperature_difference_k, "max_temperature_difference_k"));
  }
  if (request.has_max_zero_difference_um()) {
    DRIFTWISE_RETURN_IF_ERROR(
        check_positive(request.max_zero_difference_um(), "max_zero_difference_um"));
    out.rules.max_zero_difference_mm = 1e-3 * request.max_zero_difference_um();
  }
  return out;
}

}  // namespace driftwise::rpc
