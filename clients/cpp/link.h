#pragma once
// The channel to one daemon and what every call carries.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>
#include <optional>
#include <string>

#include "clients/cpp/include/driftwise/client.h"
#include "clients/cpp/reconnection.h"

namespace driftwise::client {

struct Link {
  std::string address, operator_name, bearer;
  std::optional<Failure> trouble;  // with the files of the credentials: every call fails with it
  std::shared_ptr<grpc::Channel> channel;

  Link(std::string to, std::string who, const Credentials& credentials);
  void sign(grpc::ClientContext& context) const;  // who is asking
  // Failure as the caller is told of it. Without a daemon the way back begins.
  Failure failure_of(const grpc::Status& status) const;

 private:
  std::unique_ptr<Reconnection> reconnection_;
};

}  // namespace driftwise::client
