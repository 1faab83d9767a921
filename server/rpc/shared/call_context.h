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
  // Also of a call that was allowed: its message may not be taken.
  void refuse(grpc::Status why) { refusal_ = std::move(why); }
  // Nothing: refused, or not judged: no method of ours runs.
  const std::optional<access::Identity>& who() const { return who_; }
  bool refused() const { return refusal_.has_value(); }
  // The end of a refused call; nothing: it was not refused.
  const std::optional<grpc::Status>& refusal() const { return refusal_; }

 private:
  std::optional<grpc::Status> refusal_;
  std::optional<access::Identity> who_;
};

}  // namespace driftwise::rpc
