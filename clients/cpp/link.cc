#include "clients/cpp/link.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>

namespace driftwise::client {
namespace {

std::shared_ptr<grpc::Channel> open_channel(const std::string& address) {
  grpc::ChannelArguments arguments;
  // The daemon listens on loopback, or at the end of a tunnel: never through a proxy.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // gRPC's own pause between two attempts grows to two minutes; a controller cannot wait so long.
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

Link::Link(std::string to, std::string who)
    : address(std::move(to)), operator_name(std::move(who)), channel(open_channel(address)) {}

void Link::sign(grpc::ClientContext& context) const {
  if (operator_name.empty()) return;
  const bool ascii = std::all_of(operator_name.begin(), operator_name.end(),
                                 [](char c) { return c >= 0x20 && c < 0x7F; });
  context.AddMetadata(ascii ? "driftwise-operator" : "driftwise-operator-bin", operator_name);
}

}  // namespace driftwise::client
