#include "server/rpc/caller.h"

#include "server/rpc/convert_values.h"

namespace driftwise::rpc {

application::Caller caller_of(const grpc::CallbackServerContext& context) {
  constexpr std::size_t kMostBytes = 64;
  application::Caller caller{"unknown", context.peer()};
  const auto& metadata = context.client_metadata();
  // Only the web gateway is inside the process, where gRPC knows no peer; it says who stands behind
  // it.
  if (caller.peer == "unknown" || caller.peer.starts_with("inproc")) {
    const auto behind = metadata.find("driftwise-peer");
    if (behind != metadata.end())
      caller.peer = utf8_from(std::string(behind->second.data(), behind->second.size()));
  }
  for (const char* key : {"driftwise-operator", "driftwise-operator-bin"}) {
    const auto found = metadata.find(key);
    if (found == metadata.end() || found->second.empty()) continue;
    std::string name =
        utf8_from(std::string(found->second.data(), std::min(found->second.size(), kMostBytes)));
    for (char& c : name)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
    caller.name = std::move(name);
  }
  return caller;
}

}  // namespace driftwise::rpc
