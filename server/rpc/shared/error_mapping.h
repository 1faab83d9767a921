#pragma once
// ErrorCode <-> gRPC status: the one place where they meet.
//
// A failed call carries the code, the message, and in its details a driftwise.v1.ErrorDetail with
// the stable reason, so that a program never has to read the sentence. Packed as google.rpc.Status
// (driftwise.v1.ErrorStatus, the same bytes), which is what grpc-status-details-bin holds by
// convention.

#include <grpcpp/support/status.h>

#include <exception>

#include "server/core/result.h"

namespace driftwise::rpc {

grpc::StatusCode status_code(ErrorCode code);
ErrorCode error_code(grpc::StatusCode code);  // codes we never send become internal

grpc::Status to_status(const Error& error);

// The other way: reason "" when the status holds no detail of ours.
Error to_error(const grpc::Status& status);

// The error of a call that ended with an exception, which is logged. Ports answer with Result:
// whatever is thrown is a bug of ours (BUG) or a lack of memory (OUT_OF_MEMORY).
Error error_of_exception(const std::exception& bug);

}  // namespace driftwise::rpc
