#pragma once
// A small HTTP door on loopback: /healthz, /metrics. The GUI's files and the gRPC-Web gateway will
// come in here.
//
// Thread: the executor's. The destructor closes the listening socket; connections end at their next
// read.

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "server/application/cell.h"
#include "server/core/result.h"

namespace driftwise::web {

class HttpServer {
 public:
  // address: "127.0.0.1:0" picks a free port. Errors: invalid_argument, BAD_ADDRESS (not host:port,
  // or not loopback); unavailable, CANNOT_LISTEN (port taken).
  static Result<std::unique_ptr<HttpServer>> open(asio::any_io_executor executor,
                                                  const std::string& address,
                                                  const application::Cell& cell);
  virtual ~HttpServer() = default;
  virtual std::uint16_t port() const = 0;
};

}  // namespace driftwise::web
