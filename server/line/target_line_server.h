#pragma once
// The socket of the text protocol for controllers without gRPC (docs/target-line.md): accepts,
// reads lines, answers from the newest snapshot. Rules and texts of targets are in
// server/formats/export/target_line.
//
// Thread: everything on the executor's thread, which must be one; only tokens are checked, and an
// arm's joints searched for (compensation::needs_search, ERR BUSY beyond eight that wait), on the
// background thread. Lifetime: the board, the clock and the access outlive stop() (or the
// destructor, which stops too); after it nothing of them is touched, whatever handlers are still
// queued. Limits: kMaxClients connections, formats::kMaxTargetLine bytes a line (ERR LINE_TOO_LONG,
// closed), kHandshake until TLS is agreed, kUnknown until a client that must say who it is has said
// it. Requests may be sent ahead; answers come in their order.
//
// A further client takes the place of one that has not said who it is, else of the one that has
// been idle longest: that asked nothing, or took no answer, for kIdle at least. It gets
// ERR TOO_MANY_CLIENTS and is closed when every other one is at work. TCP's keep-alive notices a
// peer that vanished without closing.

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "server/access/access.h"
#include "server/compensation/snapshot_board.h"
#include "server/core/ports/awaitable.h"
#include "server/core/ports/clock.h"
#include "server/core/result.h"
#include "server/line/line_rights.h"
#include "server/plans/joint_snapshot.h"
#include "server/tls/tls_material.h"

namespace driftwise::line {

struct LineParts {
  asio::any_io_executor executor, background;
  const compensation::SnapshotBoard& board;
  const Clock& clock;
  access::Access& access;
  const plans::JointBoard* joint = nullptr;  // of the serving plan; none: JOINT is refused
};

struct LineDoor {
  std::string address;  // "127.0.0.1:50052", "localhost:0", "[::1]:0"; port 0 picks a free one
  LineKind kind = LineKind::loopback;
  std::unique_ptr<tls::TlsMaterial> tls = nullptr;  // of LineKind::tls
  std::string interface = {};                       // of LineKind::plain_network, waited for, as
  std::vector<std::string> allow = {};              // are the addresses that may come in
};

class TargetLineServer {
 public:
  static constexpr std::size_t kMaxClients = 64;
  static constexpr std::chrono::seconds kIdle{1}, kHandshake{10}, kUnknown{30};

  // Errors: invalid_argument, BAD_ADDRESS, MISSING_KEY (no addresses that may come in);
  // failed_precondition, LISTEN_NOT_LOOPBACK (LineKind::loopback elsewhere), NOT_ON_INTERFACE;
  // unavailable, CANNOT_LISTEN.
  static Result<std::unique_ptr<TargetLineServer>> start(LineParts parts, LineDoor door);
  ~TargetLineServer();
  TargetLineServer(const TargetLineServer&) = delete;
  TargetLineServer& operator=(const TargetLineServer&) = delete;

  const std::string& address() const;  // with the real port
  std::size_t clients() const;
  std::size_t turned_away() const;  // that are not on the list of addresses
  void stop();

 private:
  class Door;
  explicit TargetLineServer(std::shared_ptr<Door> door);
  std::shared_ptr<Door> door_;
};

}  // namespace driftwise::line
