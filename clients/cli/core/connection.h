#pragma once
// The client's way to the daemon: address, deadline, who is asking, and errors as Failures with an
// exit code.

#include <google/protobuf/message.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <type_traits>

#include "clients/cli/core/clean_message.h"
#include "clients/cli/core/console.h"
#include "clients/cli/core/interrupt.h"
#include "clients/cli/core/way.h"

namespace driftwise::cli {

// Exit codes of a failed call: input 3, daemon or device away 4 (a call that the daemon's end
// cancelled too), everything else 5.
ExitCode exit_code_of(const grpc::Status& status);

// The same failure, beginning with what a person at the machine has to know whatever went wrong:
// "NOT STOPPED: use the emergency switch. ". done: "STOPPED".
Failure not_halted(const char* done, Failure failure);

class Connection {
 public:
  // out: where the command's answer goes; may be null.
  Connection(const Way& way, std::string operator_name, double timeout_s, Interrupt* interrupt,
             const std::ostream* out = nullptr);

  std::shared_ptr<grpc::Channel> channel() const { return channel_; }
  const std::string& address() const { return address_; }
  const std::string& operator_name() const { return operator_name_; }
  double timeout_s() const { return timeout_s_; }  // 0: none was asked for
  // For what has to be said after Ctrl-C too: giving up a lease.
  Connection uninterrupted() const {
    Connection copy = *this;
    copy.interrupt_ = nullptr;
    return copy;
  }
  // For what halts the robot or keeps it from going on. done: "STOPPED". Every Failure is
  // not_halted(); of a daemon that is not there the wish is kept for its next start, where this is
  // the cell's folder. nullptr: an ordinary connection again.
  Connection for_halting(const char* done) const {
    Connection copy = *this;
    copy.halting_ = done;
    return copy;
  }
  bool interrupted() const { return interrupt_ != nullptr && interrupt_->raised(); }
  bool is_heard() const { return out_ == nullptr || out_->good(); }  // what is written arrives

  // Throws Failure (bad_input, NOT_TEXT) naming the field that holds bytes which are no UTF-8: a
  // binary file taken for a trajectory. gRPC itself would send nothing and say nothing.
  static void check_text(const google::protobuf::Message& request);

  // Sets operator and deadline. usual_s: when no --timeout was given; 0: no deadline.
  void prepare(grpc::ClientContext& context, double usual_s) const;

  // One unary call: ask(&v1::RunService::Stub::GetRun, request).
  template <class Stub, class Request, class Response>
  Response ask(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
               const std::type_identity_t<Request>& request, double usual_s = 10.0) const {
    check_text(request);
    grpc::ClientContext context;
    prepare(context, usual_s);
    const Interrupt::Scope scope(interrupt_, [&context] { context.TryCancel(); });
    Stub stub(channel_);
    Response response;
    check((stub.*method)(&context, request, &response));
    clean_message(response);
    return response;
  }

  // A server stream, message by message; on_message returns false to leave. Left too when the
  // answer cannot be written any more (its reader left, its disk is full): main.cc says which.
  template <class Stub, class Request, class Response>
  void follow(std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(grpc::ClientContext*,
                                                                            const Request&),
              const std::type_identity_t<Request>& request,
              const std::type_identity_t<std::function<bool(const Response&)>>& on_message) const {
    grpc::ClientContext context;
    follow(context, method, request, on_message);
  }

  // The same in a context of the caller's, who cancels it from another thread to end it.
  template <class Stub, class Request, class Response>
  void follow(grpc::ClientContext& context,
              std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(grpc::ClientContext*,
                                                                            const Request&),
              const std::type_identity_t<Request>& request,
              const std::type_identity_t<std::function<bool(const Response&)>>& on_message) const {
    check_text(request);
    prepare(context, 0);
    const Interrupt::Scope scope(interrupt_, [&context] { context.TryCancel(); });
    Stub stub(channel_);
    const auto reader = (stub.*method)(&context, request);
    Response response;
    bool left = false;
    while (!left && reader->Read(&response)) {
      clean_message(response);
      left = !on_message(response) || !is_heard();
    }
    if (left) context.TryCancel();
    const grpc::Status status = reader->Finish();
    if (!left) check(status);
  }

 private:
  void check(const grpc::Status& status) const;  // throws Failure

  std::string hint_of(const grpc::Status& status) const;  // where nobody could be reached

  std::string address_, token_, cell_folder_, certificate_pem_, authority_pem_;
  bool tls_;
  const char* halting_ = nullptr;  // what is not done when the call fails
  std::string operator_name_;
  double timeout_s_;
  Interrupt* interrupt_;
  const std::ostream* out_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace driftwise::cli
