#pragma once
// A listening socket of the gRPC door: it holds the number of connections within bounds, which
// gRPC itself does not, and hands each one over to the server.
//
// A client beyond the quotas takes the place of the connection without a call of somebody known
// that has been silent longest; of one with such calls only when all have some. So neither idle
// connections nor streams lock a stop out, and the descriptors that the database, the devices and
// the page need stay free.
//
// Thread: one of its own, which accepts and nothing else. Made and destroyed on any other.

#include <grpcpp/server_builder.h>

#include <cstdint>
#include <memory>
#include <string>

#include "server/core/result.h"
#include "server/rpc/server/call_book.h"

namespace driftwise::rpc {

class ConnectionGate {
 public:
  struct Quotas {
    std::size_t in_all = 256;
    std::size_t per_peer = 224;  // of one address: programs of one computer are one peer
  };
  // address: "127.0.0.1:0", "localhost:50051", "[::1]:0", "unix:/path". Listens, accepts nobody
  // yet. A unix socket has mode 0600, a socket that stands in its place is removed, and only
  // processes of this user and of root come in: the kernel says whose they are. Errors:
  // invalid_argument BAD_ADDRESS (a path is at most 107 bytes); unavailable ADDRESS_IN_USE.
  static Result<std::unique_ptr<ConnectionGate>> open(const std::string& address,
                                                      std::shared_ptr<const CallBook> calls);
  static Result<std::unique_ptr<ConnectionGate>> open(const std::string& address,
                                                      std::shared_ptr<const CallBook> calls,
                                                      Quotas quotas);
  ~ConnectionGate();  // no further connection is accepted
  ConnectionGate(const ConnectionGate&) = delete;
  ConnectionGate& operator=(const ConnectionGate&) = delete;

  std::uint16_t port() const;  // 0: a unix socket
  // From now on connections go to the server that the acceptor belongs to. Once. came: told each
  // client's host on the gate's thread; nullptr: nobody is.
  void accept_for(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> server,
                  void (*came)(const std::string& host) = nullptr);

 private:
  class Listener;
  explicit ConnectionGate(std::unique_ptr<Listener> listener);
  std::unique_ptr<Listener> listener_;
};

}  // namespace driftwise::rpc
