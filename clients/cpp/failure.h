#pragma once
// A failed call as a Failure: the daemon's own reason and words where it gave them.

#include <grpcpp/support/status.h>

#include "clients/cpp/include/driftwise/client.h"

namespace driftwise::client {

Failure failure_of(const grpc::Status& status, const std::string& address);

}  // namespace driftwise::client
