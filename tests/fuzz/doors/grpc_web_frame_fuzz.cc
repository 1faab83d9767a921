// Any body: an error with a reason, or a message that fits into it.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/web/base64.h"
#include "server/web/grpc_web_call.h"
#include "server/web/grpc_web_frame.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::web;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const GrpcWebForm form : {GrpcWebForm::binary, GrpcWebForm::text}) {
    const auto message = message_of_body(bytes, form);
    if (!message && message.error().reason.empty()) std::abort();
    if (message && message->size() + 5 > size) std::abort();
  }
  if (base64_decode(base64_encode(bytes)) != bytes) std::abort();
  HttpRequest request;
  request.target = bytes;
  request.headers = {
      {"grpc-timeout", bytes}, {"driftwise-operator", bytes}, {"driftwise-operator-bin", bytes}};
  is_method_path(request.path());
  grpc_web_call(request);
  return 0;
}
