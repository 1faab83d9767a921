#include "server/rpc/shared/error_mapping.h"

#include <spdlog/spdlog.h>

#include <array>
#include <new>
#include <utility>

#include "driftwise/v1/error_detail.pb.h"
#include "server/core/reasons.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

constexpr std::array<std::pair<ErrorCode, grpc::StatusCode>, 14> kCodes = {{
    {ErrorCode::invalid_argument, grpc::StatusCode::INVALID_ARGUMENT},
    {ErrorCode::not_found, grpc::StatusCode::NOT_FOUND},
    {ErrorCode::already_exists, grpc::StatusCode::ALREADY_EXISTS},
    {ErrorCode::failed_precondition, grpc::StatusCode::FAILED_PRECONDITION},
    {ErrorCode::aborted, grpc::StatusCode::ABORTED},
    {ErrorCode::out_of_range, grpc::StatusCode::OUT_OF_RANGE},
    {ErrorCode::resource_exhausted, grpc::StatusCode::RESOURCE_EXHAUSTED},
    {ErrorCode::unavailable, grpc::StatusCode::UNAVAILABLE},
    {ErrorCode::deadline_exceeded, grpc::StatusCode::DEADLINE_EXCEEDED},
    {ErrorCode::data_loss, grpc::StatusCode::DATA_LOSS},
    {ErrorCode::permission_denied, grpc::StatusCode::PERMISSION_DENIED},
    {ErrorCode::unauthenticated, grpc::StatusCode::UNAUTHENTICATED},
    {ErrorCode::cancelled, grpc::StatusCode::CANCELLED},
    {ErrorCode::internal, grpc::StatusCode::INTERNAL},
}};

}  // namespace

grpc::StatusCode status_code(ErrorCode code) {
  for (const auto& [ours, theirs] : kCodes)
    if (ours == code) return theirs;
  return grpc::StatusCode::INTERNAL;
}

ErrorCode error_code(grpc::StatusCode code) {
  for (const auto& [ours, theirs] : kCodes)
    if (theirs == code) return ours;
  return ErrorCode::internal;
}

grpc::Status to_status(const Error& error) {
  // A message becomes an HTTP/2 header: peers refuse headers of more than 8 KiB, so a long one is
  // cut there.
  constexpr std::size_t kMostBytes = 2000;
  std::string message = utf8_from(error.message);
  if (message.size() > kMostBytes) message = utf8_from(message.substr(0, kMostBytes)) + " ...";
  const grpc::StatusCode code = status_code(error.code);
  v1::ErrorDetail detail;
  detail.set_reason(error.reason);
  detail.set_message(message);
  v1::ErrorStatus status;
  status.set_code(code);
  status.set_message(message);
  status.add_details()->PackFrom(detail);
  return {code, message, status.SerializeAsString()};
}

Error to_error(const grpc::Status& status) {
  Error error{error_code(status.error_code()), "", status.error_message()};
  v1::ErrorStatus packed;
  if (!packed.ParseFromString(status.error_details())) return error;
  for (const auto& any : packed.details()) {
    v1::ErrorDetail detail;
    if (any.UnpackTo(&detail)) {
      error.reason = detail.reason();
      error.message = detail.message();
    }
  }
  return error;
}

Error error_of_exception(const std::exception& bug) {
  spdlog::error("a call ended with an exception: {}", bug.what());
  if (dynamic_cast<const std::bad_alloc*>(&bug) != nullptr)
    return {ErrorCode::resource_exhausted, reasons::kOutOfMemory,
            "the daemon has too little memory for this answer: ask for less of it"};
  return {ErrorCode::internal, reasons::kBug, std::string("the daemon met a bug: ") + bug.what()};
}

}  // namespace driftwise::rpc
