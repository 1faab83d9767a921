#pragma once
// Server streams with back-pressure: a stream asks its source for the next message only when the
// last one has gone out, so a slow client costs one message of memory and never slows whoever
// produces.
//
// All of a stream's own code runs on the executor's thread: gRPC's callbacks only post there, hence
// no mutex. A Stream keeps itself alive until gRPC is done with it. It ends when the source says
// so, when the client goes away, or when the server shuts down; the source (with its watches) is
// destroyed on the executor's thread.

#include <grpcpp/support/server_callback.h>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "server/core/result.h"
#include "server/rpc/shared/error_mapping.h"

namespace driftwise::rpc {

// Where a stream's messages come from. Called on the executor's thread only.
template <class Message>
class StreamSource {
 public:
  virtual ~StreamSource() = default;
  // wake: to be called (on the executor's thread, as often as one likes) when next() or ended() may
  // have news. It stays callable for as long as the source lives.
  virtual void start(std::function<void()> wake) = 0;
  virtual std::optional<Message> next() = 0;  // the next message to send; nothing: not yet
  virtual std::optional<Result<void>>
  ended() = 0;  // asked when next() has nothing: the stream's end, if it is there
};

template <class Message>
class Stream final : public grpc::ServerWriteReactor<Message>,
                     public std::enable_shared_from_this<Stream<Message>> {
 public:
  static grpc::ServerWriteReactor<Message>* open(boost::asio::any_io_executor executor,
                                                 std::unique_ptr<StreamSource<Message>> source) {
    auto stream = std::shared_ptr<Stream>(new Stream(std::move(executor), std::move(source)));
    stream->self_ = stream;
    boost::asio::post(stream->executor_, [stream] {
      if (stream->finished_) return;
      // The source must not keep the stream alive, the stream owns it.
      stream->source_->start([weak = std::weak_ptr<Stream>(stream)] {
        if (const auto alive = weak.lock()) alive->pump_soon();
      });
      stream->pump();
    });
    return stream.get();
  }

  void OnWriteDone(bool ok) override {
    boost::asio::post(executor_, [self = this->shared_from_this(), ok] {
      self->writing_ = false;
      if (!ok) self->cancelled_ = true;
      self->pump();
    });
  }
  void OnCancel() override {
    boost::asio::post(executor_, [self = this->shared_from_this()] {
      self->cancelled_ = true;
      self->pump();
    });
  }
  void OnDone() override {
    const auto executor =
        executor_;  // the handler may run, and end this object, before post() returns
    boost::asio::post(executor, [self = std::move(self_)] { self->source_.reset(); });
  }

 private:
  Stream(boost::asio::any_io_executor executor, std::unique_ptr<StreamSource<Message>> source)
      : executor_(std::move(executor)), source_(std::move(source)) {}

  // Never from within next() or ended(): a source may wake while it is being asked.
  void pump_soon() {
    if (std::exchange(pump_posted_, true)) return;
    boost::asio::post(executor_, [self = this->shared_from_this()] {
      self->pump_posted_ = false;
      self->pump();
    });
  }

  void pump() {
    if (writing_ || finished_) return;
    if (cancelled_)
      return finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client went away"));
    if (auto message = source_->next()) {
      message_ = std::move(*message);
      writing_ = true;
      this->StartWrite(&message_);
      return;
    }
    if (const auto end = source_->ended())
      finish(*end ? grpc::Status::OK : to_status(end->error()));
  }

  void finish(const grpc::Status& status) {
    finished_ = true;
    this->Finish(status);
  }

  boost::asio::any_io_executor executor_;
  std::unique_ptr<StreamSource<Message>> source_;
  std::shared_ptr<Stream> self_;
  Message message_;
  bool writing_ = false, cancelled_ = false, finished_ = false, pump_posted_ = false;
};

// A stream that is refused before it begins.
template <class Message>
grpc::ServerWriteReactor<Message>* refuse_stream(const Error& error) {
  class Refused final : public grpc::ServerWriteReactor<Message> {
   public:
    explicit Refused(const Error& why) { this->Finish(to_status(why)); }
    void OnDone() override { delete this; }
  };
  return new Refused(error);
}

}  // namespace driftwise::rpc
