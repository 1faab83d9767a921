#include "server/rpc/shared/caller.h"

#include "server/core/text/clean_text.h"

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
      caller.peer = clean_line({behind->second.data(), behind->second.size()});
  }
  for (const char* key : {"driftwise-operator", "driftwise-operator-bin"}) {
    const auto found = metadata.find(key);
    if (found == metadata.end() || found->second.empty()) continue;
    caller.name = clean_line({found->second.data(), std::min(found->second.size(), kMostBytes)});
  }
  return caller;
}

}  // namespace driftwise::rpc
