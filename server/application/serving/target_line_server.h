#pragma once
// The socket of the text protocol for controllers without gRPC (docs/target-line.md): accepts,
// reads lines, answers from the newest snapshot. Rules and texts are in server/formats/target_line.
//
// Thread: everything on the executor's thread, which must be one. Lifetime: the board and the clock
// outlive stop() (or the destructor, which stops too); after it nothing of them is touched,
// whatever handlers are still queued. Limits: kMaxClients connections, formats::kMaxTargetLine
// bytes a line (ERR LINE_TOO_LONG, closed). Requests may be sent ahead; answers come in their
// order.
//
// A further client takes the place of the one that has been idle longest: that asked nothing, or
// took no answer, for kIdle at least. It gets ERR TOO_MANY_CLIENTS and is closed when every other
// one is at work. TCP's keep-alive notices a peer that vanished without closing.

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "server/compensation/snapshot_board.h"
#include "server/core/ports/clock.h"
#include "server/core/result.h"

namespace driftwise::application {

class TargetLineServer {
 public:
  static constexpr std::size_t kMaxClients = 64;
  static constexpr std::chrono::seconds kIdle{1};

  // address: "127.0.0.1:50052", "localhost:0", "[::1]:0"; port 0 picks a free one.
  // Errors: invalid_argument, BAD_ADDRESS; failed_precondition, LISTEN_NOT_LOOPBACK; unavailable,
  // CANNOT_LISTEN.
  static Result<std::unique_ptr<TargetLineServer>> start(asio::any_io_executor executor,
                                                         const std::string& address,
                                                         const compensation::SnapshotBoard& board,
                                                         const Clock& clock);
  ~TargetLineServer();
  TargetLineServer(const TargetLineServer&) = delete;
  TargetLineServer& operator=(const TargetLineServer&) = delete;

  const std::string& address() const;  // with the real port
  std::size_t clients() const;
  void stop();

 private:
  class Door;
  explicit TargetLineServer(std::shared_ptr<Door> door);
  std::shared_ptr<Door> door_;
};

}  // namespace driftwise::application
