#pragma once
// The HTTP door, with a thread of its own: whatever clients do here, the cell's
// executor does not feel it.
//
// At most kMaxConnections at a time, kMaxPerPeer of one address. A further client takes the place
// of the slowest of them (door_quotas.h), streams and unfinished requests included: it may be the
// one that stops a motion. Bodies share a budget of memory (body_budget.h).

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/core/result.h"
#include "server/tls/tls_material.h"
#include "server/web/door_quotas.h"
#include "server/web/http_message.h"

namespace driftwise::web {

class HttpServer {
 public:
  static constexpr std::size_t kMaxConnections = DoorQuotas{}.in_all;
  static constexpr std::size_t kMaxPerPeer = DoorQuotas{}.per_peer;

  // Listens, answers nobody yet: clients wait. address: "127.0.0.1:0" picks a free port. tls: none
  // for plain HTTP, which only loopback may have. Errors: invalid_argument, BAD_ADDRESS (not
  // host:port), NEEDS_TLS (plain outside loopback); unavailable, CANNOT_LISTEN (port taken).
  static Result<std::unique_ptr<HttpServer>> open(const std::string& address,
                                                  std::unique_ptr<tls::TlsMaterial> tls = nullptr);
  // Ends what is under way and waits for it: the cell's executor and the gRPC server must still
  // run.
  virtual ~HttpServer() = default;

  virtual std::uint16_t port() const = 0;
  virtual std::string address() const = 0;                 // "127.0.0.1:40200", "[::1]:40200"
  virtual std::string origin() const = 0;                  // "https://192.168.7.1:8443"
  virtual asio::any_io_executor executor() const = 0;      // the web thread
  virtual void serve(std::unique_ptr<HttpSite> site) = 0;  // once
};

}  // namespace driftwise::web
