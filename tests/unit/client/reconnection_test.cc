// The way back to a lost daemon: many calls report the loss at once, and an end does not wait for
// a daemon.

#include "clients/cpp/reconnection.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

// Reports of the thread sanitizer from within gRPC. Debian's is not instrumented, so that its locks
// are not seen.
extern "C" const char* __tsan_default_suppressions();   // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race:libgrpc\nrace:libgpr\nrace:libabsl\n";
}

namespace driftwise::client {
namespace {

using std::chrono::seconds;

// A loopback port whose backlog takes a connection and whose owner never answers it.
class SilentDoor {
 public:
  SilentDoor() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof where;
    auto* address = reinterpret_cast<sockaddr*>(&where);
    EXPECT_EQ(::bind(socket_, address, size), 0);
    EXPECT_EQ(::listen(socket_, 8), 0);
    EXPECT_EQ(::getsockname(socket_, address, &size), 0);
    port_ = ntohs(where.sin_port);
  }
  ~SilentDoor() { ::close(socket_); }
  SilentDoor(const SilentDoor&) = delete;
  SilentDoor& operator=(const SilentDoor&) = delete;
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  int socket_, port_ = 0;
};

std::shared_ptr<grpc::Channel> channel_to(const std::string& address) {
  return grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
}

void tell_from_many_threads(Reconnection& reconnection) {
  std::vector<std::thread> calls;
  for (int i = 0; i < 8; ++i)
    calls.emplace_back([&reconnection] {
      for (int j = 0; j < 50; ++j) reconnection.lost();
    });
  for (auto& call : calls) call.join();
}

TEST(Reconnection, FindsTheDaemonThatManyCallsReportLost) {
  grpc::AsyncGenericService service;
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterAsyncGenericService(&service);
  const auto queue = builder.AddCompletionQueue();
  const auto server = builder.BuildAndStart();
  ASSERT_NE(server, nullptr);
  const auto channel = channel_to("127.0.0.1:" + std::to_string(port));
  {
    Reconnection reconnection(channel);
    tell_from_many_threads(reconnection);
    // No call is under way: the thread alone moves the connection forward.
    const auto end = std::chrono::steady_clock::now() + seconds(30);
    while (channel->GetState(false) != GRPC_CHANNEL_READY && std::chrono::steady_clock::now() < end)
      std::this_thread::yield();
    EXPECT_EQ(channel->GetState(false), GRPC_CHANNEL_READY);
  }
  server->Shutdown(std::chrono::system_clock::now());
  queue->Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue->Next(&tag, &ok)) {
  }
}

TEST(Reconnection, EndsAtOnceWhileNobodyAnswers) {
  const SilentDoor door;
  const auto begun = std::chrono::steady_clock::now();
  {
    Reconnection reconnection(channel_to(door.address()));
    tell_from_many_threads(reconnection);
  }
  // gRPC gives up such an attempt after 20 s.
  EXPECT_LT(std::chrono::steady_clock::now() - begun, seconds(10));
}

TEST(Reconnection, OfAConnectionThatIsNeverLostStartsNoThread) {
  const SilentDoor door;
  const auto channel = channel_to(door.address());
  { const Reconnection reconnection(channel); }
  EXPECT_EQ(channel->GetState(false), GRPC_CHANNEL_IDLE);
}

}  // namespace
}  // namespace driftwise::client
