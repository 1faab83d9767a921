#pragma once
// A real gRPC server on a free port over a real cell, and a client's view of it.

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>

#include <chrono>

#include "server/rpc/server/rpc_server.h"
#include "server/rpc/shared/error_mapping.h"
#include "tests/support/fakes.h"

namespace driftwise::tests {

class RpcTest : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = rpc::RpcServer::open(cell.services(fakes), door_address);
    if (!opened) throw std::runtime_error(opened.error().message);
    server = std::move(*opened);
    server->ready(true);
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetMaxReceiveMessageSize(-1);
    arguments.SetMaxSendMessageSize(-1);
    channel =
        grpc::CreateCustomChannel(server->address(), grpc::InsecureChannelCredentials(), arguments);
  }
  void TearDown() override { server.reset(); }

  struct Call : grpc::ClientContext {
    explicit Call(const std::string& operator_name = "ada") {
      AddMetadata("driftwise-operator", operator_name);
      set_deadline(std::chrono::system_clock::now() +
                   std::chrono::seconds(20));  // a hang fails instead
    }
  };

  std::string door_address = "127.0.0.1:0";  // set before SetUp()

  // One unary call; the response, or the error with its reason.
  template <class Stub, class Request, class Response>
  Result<Response> ask(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                    Response*),
                       const std::type_identity_t<Request>& request,
                       const std::string& operator_name = "ada") {
    Call call(operator_name);
    Stub stub(channel);
    Response response;
    const grpc::Status status = (stub.*method)(&call, request, &response);
    if (!status.ok()) return tl::unexpected(rpc::to_error(status));
    return response;
  }

  // Waits for something that happens on another thread; false when it did not within 20 s.
  template <class Condition>
  bool eventually(Condition condition) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < until) {
      if (cell.on_executor(condition)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

  LiveCell cell;
  Fakes fakes;  // set by the test's constructor
  std::unique_ptr<rpc::RpcServer> server;
  std::shared_ptr<grpc::Channel> channel;
};

// EXPECT_THAT(result, FailsWith(ErrorCode::not_found, "NO_RUN"));
MATCHER_P2(FailsWith, code, reason, "") {
  if (arg) {
    *result_listener << "it succeeded";
    return false;
  }
  *result_listener << to_string(arg.error().code) << " " << arg.error().reason << ": "
                   << arg.error().message;
  return arg.error().code == code && arg.error().reason == reason && !arg.error().message.empty();
}

}  // namespace driftwise::tests
