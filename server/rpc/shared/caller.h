#pragma once
// Who calls, from a call's metadata and peer. The name is typed by the client and unverified until
// roles exist.

#include <grpcpp/server_context.h>

#include "server/application/ports/caller.h"

namespace driftwise::rpc {

// Metadata "driftwise-operator" (ASCII) or "driftwise-operator-bin" (any UTF-8): the first 64
// characters, cleaned (core/clean_text.h). Without either: "unknown". The peer as gRPC prints it:
// "ipv4:127.0.0.1:5020"; of a call that came through the web gateway, the browser's.
application::Caller caller_of(const grpc::CallbackServerContext& context);

}  // namespace driftwise::rpc
