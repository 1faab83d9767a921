#pragma once
// What a gRPC-Web request asks for: which method, with which metadata, until when. Pure.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"
#include "server/web/http_message.h"

namespace driftwise::web {

struct GrpcWebCall {
  std::string method;                // "/driftwise.v1.RunService/GetRun"
  std::vector<HttpHeader> metadata;  // fit for gRPC: it aborts the process at what it calls illegal
  std::optional<std::chrono::nanoseconds> timeout;
};

// "/driftwise.v1.Service/Method": ours, and of letters and digits.
bool is_method_path(std::string_view path);

// Metadata: the caller's name ("driftwise-operator", or "-bin" in base64), what it has heard last
// ("driftwise-heard-ms"), and as "driftwise-peer" the HTTP client's address, which only the gateway
// can say. Errors: invalid_argument BAD_TIMEOUT,
// BAD_METADATA.
Result<GrpcWebCall> grpc_web_call(const HttpRequest& request);

}  // namespace driftwise::web
