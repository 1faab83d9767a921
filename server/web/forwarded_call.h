#pragma once
// One gRPC call made for somebody else: bytes in, bytes out, whatever the method. gRPC's callbacks
// only post to the executor; everything else happens on its one thread, hence no mutex.
//
// gRPC is asked for the first message at once and for another one only by next(): back-pressure
// reaches the service. A call must
// be taken to its end (next() said so) or cancelled; it keeps itself alive until gRPC is done with
// it.

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <optional>

#include "server/application/plumbing/signal.h"
#include "server/web/grpc_web_call.h"

namespace driftwise::web {

class ForwardedCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                            public std::enable_shared_from_this<ForwardedCall> {
 public:
  // Not yet begun. The executor has work until gRPC is done with the call: who runs an io_context
  // until it runs out of work has waited for every call.
  explicit ForwardedCall(const asio::any_io_executor& executor);
  ForwardedCall(const ForwardedCall&) = delete;

  void begin(grpc::GenericStub& stub, const GrpcWebCall& what, std::string_view message);
  // The next message; nothing: the call is over, and status() is there.
  Awaitable<std::optional<grpc::ByteBuffer>> next();
  const grpc::Status& status() const { return status_; }
  void cancel();  // idempotent; next(), if it waits, returns soon

 private:
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void let_go();

  asio::any_io_executor executor_;
  application::Signal changed_;
  grpc::ClientContext context_;
  grpc::ByteBuffer request_, response_;
  grpc::Status status_;
  std::shared_ptr<ForwardedCall> self_;
  bool reading_ = false, message_there_ = false, held_ = false, cancelled_ = false, over_ = false;
};

}  // namespace driftwise::web
