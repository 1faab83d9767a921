#include "clients/cpp/failure.h"

#include "driftwise/v1/error_detail.pb.h"

namespace driftwise::client {

Failure failure_of(const grpc::Status& status, const std::string& address) {
  v1::ErrorStatus packed;
  v1::ErrorDetail detail;
  if (packed.ParseFromString(status.error_details()))
    for (const auto& any : packed.details()) any.UnpackTo(&detail);
  if (!detail.reason().empty())
    return {detail.reason(), detail.message().empty() ? status.error_message() : detail.message()};
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
    return {"TIMEOUT", "no answer from " + address + " within the time limit"};
  // A daemon gives its reason. Without one gRPC speaks for it: it is away, or it ends and cancels
  // what is under way.
  return {"NO_DAEMON", "no daemon answers at " + address + ": is driftwised running there? (code " +
                           std::to_string(status.error_code()) + ": " + status.error_message() +
                           ")"};
}

}  // namespace driftwise::client
