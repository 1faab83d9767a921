#pragma once
// The door for signs of life: HTTP, or HTTPS with a certificate. POST of a sign of life (JSON, 64
// kB at most) with "Authorization: Bearer TOKEN" where a token is wanted. 204: taken.
//
// A further client is always let in, as its sign of life may be the one that is waited for: it
// takes the place of a connection that has brought no sign yet, of the address with the most of
// those the oldest; else of the one without a sign for longest. One thread, that of the executor.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <string>

#include "server/core/ports/awaitable.h"
#include "server/core/records/notify_records.h"
#include "server/core/result.h"
#include "server/tls/tls_material.h"

namespace driftwise::watchdog {

struct DoorOptions {
  std::string listen;  // "0.0.0.0:9470"
  std::string token;   // empty: none is wanted, which only loopback may have
  std::unique_ptr<tls::TlsMaterial> tls;
};

class WatchdogDoor {
 public:
  static constexpr std::size_t kMaxConnections = 64;
  using Take = std::function<Result<void>(const LifeSign&)>;

  // Errors: invalid_argument BAD_ADDRESS, NEEDS_TLS (outside loopback without a token, or with a
  // token that would cross the network readable); unavailable CANNOT_LISTEN.
  static Result<std::unique_ptr<WatchdogDoor>> open(asio::any_io_executor executor,
                                                    DoorOptions options, Take take);
  virtual ~WatchdogDoor() = default;
  virtual std::string address() const = 0;
};

}  // namespace driftwise::watchdog
