#pragma once
// The gRPC door of the daemon: the services, health and reflection on one loopback address.
//
// Health is NOT_SERVING for "" and for each service until ready(true). Limits: a request of at most
// 33 MiB (a dataset of 32 MiB and its envelope), an answer of at most 64 MiB (10 000 points are
// about 4 MiB); metadata of 16 KiB; connections as connection_gate.h has it, streams as call_book.h
// has it, 128 calls of one connection at a time; kMostBufferBytes of what the network has brought
// and no service has taken yet: beyond it gRPC closes idle connections and ends calls. An idle peer
// is asked for a sign of life every minute. A call's deadline is the client's; without one it
// waits. The callbacks run on gRPC's own threads and never block.
//
// Thread: made, used and destroyed on one thread that is not the cell's executor; shut_down()
// blocks until every call has ended, so the cell's executor must still be running then. The cell
// outlives it.

#include <grpcpp/server.h>

#include <memory>
#include <string>
#include <vector>

#include "server/application/cell/services.h"
#include "server/application/ports/host.h"
#include "server/rpc/server/call_book.h"
#include "server/rpc/server/connection_gate.h"

namespace driftwise::rpc {

class RpcServer {
 public:
  static constexpr std::size_t kMostBufferBytes = std::size_t{192} << 20;

  // listen: "127.0.0.1:50051"; port 0 picks a free one. further: services beside ours, for the
  // in-process gateway of the web and for benchmarks; borrowed. Errors: invalid_argument
  // NOT_LOOPBACK (only loopback, until TLS and roles are configured), BAD_ADDRESS; unavailable,
  // ADDRESS_IN_USE.
  static Result<std::unique_ptr<RpcServer>> open(const application::Services& cell,
                                                 const std::string& listen,
                                                 std::vector<grpc::Service*> further = {});
  ~RpcServer();

  std::string address() const { return address_; }  // with the port chosen: "127.0.0.1:40200"
  void ready(bool is_ready);
  // Streams are ended at once, unary calls under way may finish within the grace.
  // Idempotent.
  void shut_down(std::chrono::milliseconds grace);

  // For the gRPC-Web gateway: a channel without a socket.
  std::shared_ptr<grpc::Channel> in_process_channel();

 private:
  RpcServer() = default;
  std::vector<std::unique_ptr<grpc::Service>> services_;  // outlive the server
  std::shared_ptr<CallBook> calls_;
  std::unique_ptr<ConnectionGate> gate_;  // ends before the server
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  const application::Host* host_ = nullptr;
};

}  // namespace driftwise::rpc
