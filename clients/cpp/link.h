#pragma once
// The channel to one daemon and what every call carries.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>
#include <string>

namespace driftwise::client {

struct Link {
  std::string address, operator_name;
  std::shared_ptr<grpc::Channel> channel;

  Link(std::string to, std::string who);
  void sign(grpc::ClientContext& context) const;  // who is asking
};

}  // namespace driftwise::client
