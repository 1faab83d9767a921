#pragma once
// A call of ours, with who asks: the guard fills it in before the service is reached.

#include <grpcpp/server_context.h>

#include <optional>
#include <utility>

#include "server/access/identity.h"

namespace driftwise::rpc {

class CallContext final : public grpc::CallbackServerContext {
 public:
  void allow(access::Identity who) { who_ = std::move(who); }
  void refuse() { refused_ = true; }
  // Nothing: refused, or not judged: no method of ours runs.
  const std::optional<access::Identity>& who() const { return who_; }
  bool refused() const { return refused_; }

 private:
  bool refused_ = false;
  std::optional<access::Identity> who_;
};

}  // namespace driftwise::rpc
