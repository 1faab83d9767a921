#include "server/web/forwarded_call.h"

#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>

namespace driftwise::web {

ForwardedCall::ForwardedCall(const asio::any_io_executor& executor)
    : executor_(asio::prefer(executor, asio::execution::outstanding_work.tracked)),
      changed_(executor) {}

void ForwardedCall::begin(grpc::GenericStub& stub, const GrpcWebCall& what,
                          std::string_view message) {
  self_ = shared_from_this();
  for (const auto& [name, value] : what.metadata) context_.AddMetadata(name, value);
  if (what.timeout)
    context_.set_deadline(
        std::chrono::system_clock::now() +
        std::chrono::duration_cast<std::chrono::system_clock::duration>(*what.timeout));
  const grpc::Slice slice(message.data(), message.size());
  request_ = grpc::ByteBuffer(&slice, 1);
  stub.PrepareBidiStreamingCall(&context_, what.method, {}, this);
  AddHold();  // reads are asked for from outside gRPC's callbacks
  held_ = true;
  StartWriteLast(&request_, grpc::WriteOptions());
  // The transport inside a process drops a message that comes together with the status when nobody
  // reads yet, and its call then never ends.
  reading_ = true;
  StartRead(&response_);
  StartCall();
}

Awaitable<std::optional<grpc::ByteBuffer>> ForwardedCall::next() {
  if (!over_ && held_ && !reading_ && !message_there_) {
    reading_ = true;
    StartRead(&response_);
  }
  while (!message_there_ && !over_) co_await changed_.wait();
  if (!message_there_) co_return std::nullopt;
  message_there_ = false;
  std::optional<grpc::ByteBuffer> out(std::in_place);
  out->Swap(&response_);
  co_return out;
}

void ForwardedCall::cancel() {
  if (over_ || std::exchange(cancelled_, true)) return;
  context_.TryCancel();
  if (!reading_) let_go();
}

void ForwardedCall::OnReadDone(bool ok) {
  asio::post(executor_, [self = shared_from_this(), ok] {
    self->reading_ = false;
    self->message_there_ = ok;
    if (!ok || self->cancelled_) self->let_go();
    self->changed_.raise();
  });
}

void ForwardedCall::OnDone(const grpc::Status& status) {
  asio::post(executor_, [self = shared_from_this(), status] {
    self->status_ = status;
    self->over_ = true;
    self->changed_.raise();
    self->self_.reset();
  });
}

void ForwardedCall::let_go() {
  if (std::exchange(held_, false)) RemoveHold();
}

}  // namespace driftwise::web
