#include "server/rpc/shared/caller.h"

#include "server/access/peer_name.h"
#include "server/core/text/clean_text.h"
#include "server/rpc/shared/call_context.h"

namespace driftwise::rpc {

std::string_view metadata_value(const grpc::ServerContextBase& context, const char* key) {
  const auto& metadata = context.client_metadata();
  const auto found = metadata.find(key);
  if (found == metadata.end()) return {};
  return {found->second.data(), found->second.size()};
}

bool from_inside(const grpc::ServerContextBase& context) {
  const std::string peer = context.peer();
  return peer == "unknown" || peer.starts_with("inproc");
}

std::string peer_of(const grpc::ServerContextBase& context) {
  // The gateway says who stands behind it.
  if (from_inside(context))
    if (const auto behind = metadata_value(context, "driftwise-peer"); !behind.empty())
      return clean_line(behind);
  return access::peer_name_from_grpc(context.peer());
}

std::string stated_name(const grpc::ServerContextBase& context) {
  constexpr std::size_t kMostBytes = 64;
  std::string name;
  for (const char* key : {"driftwise-operator", "driftwise-operator-bin"})
    if (const auto found = metadata_value(context, key); !found.empty())
      name = clean_line(found.substr(0, kMostBytes));
  return name;
}

const access::Identity& identity_of(const grpc::CallbackServerContext& context) {
  static const access::Identity nobody{"unknown", access::Role::viewer,
                                       access::Proof::open_loopback, "", "unknown"};
  const auto* call = dynamic_cast<const CallContext*>(&context);
  return call && call->who() ? *call->who() : nobody;
}

application::Caller caller_of(const grpc::CallbackServerContext& context) {
  const auto& who = identity_of(context);
  if (who.proof == access::Proof::open_loopback) return {who.name, who.from, {}};
  std::string proof(to_string(who.proof));
  if (!who.credential.empty()) proof += " " + who.credential;
  return {who.name, who.from + " (" + proof + ")", proof};
}

}  // namespace driftwise::rpc
