#pragma once
// The gRPC door of the daemon: the services, health and reflection on one loopback address, and
// where access is given on a unix socket in the state folder and on an address with TLS. Every call
// passes the guard (guard.h).
//
// Certificate and key are read again when their files change, within kReload_s; connections that
// stand keep theirs.
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

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/access/access.h"
#include "server/application/cell/services.h"
#include "server/application/ports/host.h"
#include "server/rpc/server/call_book.h"
#include "server/rpc/server/connection_gate.h"

namespace driftwise::rpc {

class RpcServer {
 public:
  static constexpr std::size_t kMostBufferBytes = std::size_t{192} << 20;
  static constexpr unsigned kReload_s = 5;

  // listen: "127.0.0.1:50051"; port 0 picks a free one. further: services beside ours, for
  // benchmarks; borrowed, without a guard. access: outlives the server; nullptr: whoever reaches
  // the loopback address is admin. Errors: invalid_argument NOT_LOOPBACK (the address without TLS),
  // BAD_ADDRESS; unavailable, ADDRESS_IN_USE; internal NO_ROLE (an rpc declares no role).
  static Result<std::unique_ptr<RpcServer>> open(const application::Services& cell,
                                                 const std::string& listen,
                                                 std::vector<grpc::Service*> further = {},
                                                 access::Access* access = nullptr);
  ~RpcServer();

  std::string address() const { return address_; }  // with the port chosen: "127.0.0.1:40200"
  std::string tls_address() const { return tls_address_; }  // likewise; empty: no such door
  std::string socket_path() const { return socket_path_; }  // empty: no such door
  void ready(bool is_ready);
  // Streams are ended at once, unary calls under way may finish within the grace and are cancelled
  // then. Returns at most a second after the grace. False: the work of a call has not ended, and
  // this cannot be destroyed before it has. May be called again.
  bool shut_down(std::chrono::milliseconds grace);

  // For the gRPC-Web gateway: a channel without a socket.
  std::shared_ptr<grpc::Channel> in_process_channel();

 private:
  struct Building;
  RpcServer() = default;
  Result<void> add_services(const application::Services& cell, Building& building);
  Result<void> add_door(Building& building, const std::string& address,
                        std::shared_ptr<grpc::ServerCredentials> credentials);
  Result<void> add_doors(Building& building, const std::string& listen, access::Access* access);

  std::unique_ptr<access::Authoriser> own_authoriser_;    // where no access is given
  std::vector<std::unique_ptr<grpc::Service>> services_;  // outlive the server, as
  std::vector<std::unique_ptr<grpc::Service>> guarded_;   // do those before them
  std::shared_ptr<CallBook> calls_;
  std::vector<std::unique_ptr<ConnectionGate>> gates_;  // end before the server
  std::unique_ptr<grpc::Server> server_;
  std::thread closing_;  // the library waits for every handler, however long it takes
  std::future<void> closed_;
  std::string address_, tls_address_, socket_path_;
  const application::Host* host_ = nullptr;
};

}  // namespace driftwise::rpc
