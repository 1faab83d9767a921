#pragma once
// One device on one line: connect, ask, wait for the complete answer or say exactly what happened.

#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/transport/back_off.h"
#include "drivers/transport/byte_stream.h"
#include "drivers/transport/exchange_log.h"
#include "drivers/transport/framing.h"
#include "server/core/ports/clock.h"
#include "server/core/ports/device.h"

namespace driftwise::transport {

inline constexpr std::chrono::milliseconds kShortestTimeout{
    250};  // of wall time, however fast the cell runs

struct LinkSettings {
  std::string device, address;  // for messages
  std::size_t max_reply_bytes = 65536;
  BackOff::Bounds back_off;
  Framing framing = line_reply;
  // After a time-out or a stop an answer may still be under way and must not be taken for the next
  // one. Before the next exchange the link sends resync_prefix at once, then resync_request, and
  // drops everything up to the answer that is_resync_reply knows (an identity: nothing else looks
  // like it). Without a request the link reconnects instead.
  std::string resync_prefix, resync_request;
  std::function<bool(std::string_view reply)> is_resync_reply;
};

// Reconnects with back-off (see BackOff), never within an exchange: the owner looks at is_set_up(),
// sets its device up again when that is false, and says when that is done: a device that answers
// and cannot be set up is backed off from as one that is away. A set-up ends with the connection,
// and with an answer that did not come: on a serial line a device may have lost its mains and come
// back without a new connection, and its identity is the same. One exchange at
// a time; a second one answers internal, reason BUSY. Errors: unavailable (LINK_DOWN: cannot
// connect; LINK_LOST: broken in mid-exchange), deadline_exceeded (TIMEOUT), aborted (what abort()
// was told), data_loss (REPLY_TOO_LONG). Each names device, address, sent, received and after how
// long. All on the executor's thread. Destroy it only when no call is under way or the executor has
// stopped.
class Link {
 public:
  Link(asio::any_io_executor executor, Clock& clock, LinkSettings settings,
       std::unique_ptr<ByteStream> stream);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  // Connects when not connected: waits out the back-off, but no longer than the time-out. Notices a
  // line that the other side has closed meanwhile.
  Awaitable<Result<void>> connect(Nanoseconds timeout);
  // Sends the request and returns `replies` complete replies in one piece, as they came.
  Awaitable<Result<std::string>> ask(std::string request, Nanoseconds timeout, int replies = 1);
  // Sends resync_request and throws away what comes before its answer, when out of step. ask() and
  // tell() do it themselves.
  Awaitable<Result<void>> get_in_step(Nanoseconds timeout);
  // Reads until nothing has come for so long, and throws away what came: of a device that knows no
  // resync_request, an answer that is still under way to whoever is connected. Errors besides:
  // data_loss OUT_OF_STEP: it talks without end.
  Awaitable<Result<void>> await_silence(Nanoseconds silence);
  // Sends a command that is never answered.
  Awaitable<Result<void>> tell(std::string command, Nanoseconds timeout);

  // For a stop: writes at once, whatever is under way, and ends that with aborted. Not connected:
  // the next connect() does not back off, and one that is under way ends without back-off.
  error_code interrupt(std::string_view bytes, std::string why);
  // The same without ending anything: for bytes that are never answered. No-op when not connected.
  error_code write_now(std::string_view bytes);
  void drop(const std::string& why);  // closes the line; the next connect() backs off
  // The same of a device that cannot be set up: connect() answers with this until the next attempt.
  void drop(const Error& refusal);
  void close();  // by its owner: a pending call is aborted, no back-off

  bool connected() const { return connected_; }
  // What the other end is known by, address_key.h; empty when not connected.
  std::string peer_key() const { return connected_ ? stream_->peer_key() : std::string(); }
  std::int64_t generation() const { return generation_; }  // counts connections
  // By its owner, for this connection. An error of before is over. From now on, or at once when it
  // has answered, an answer is a success for the back-off.
  void device_is_set_up();
  bool is_set_up() const { return connected_ && is_set_up_; }
  void lose_set_up() { is_set_up_ = false; }  // the owner got an answer that contradicts the set-up
  bool in_step() const { return in_step_; }
  void lose_step() { in_step_ = false; }  // the owner got an answer that makes no sense
  // How often a call ended with an answer under way: for others on the same line.
  std::int64_t lost_steps() const { return lost_steps_; }

  // An error of the owner's codec about the last answer, with device, address and the exchange
  // around it. Counts it.
  tl::unexpected<Error> wrong_reply(const Error& error);
  tl::unexpected<Error> refused(std::string reason,
                                const std::string& message);  // failed_precondition, likewise
  void set_identity(std::string identity) { health_.identity = std::move(identity); }
  const DeviceHealth& health() const { return health_; }
  const ExchangeLog& log() const { return log_; }

 private:
  class Running;
  Awaitable<Result<std::string>> talk(std::string request, Nanoseconds timeout, int replies);
  bool still_there();
  void start_timer(std::chrono::nanoseconds limit);
  void disconnect(LinkState state);
  Error ended(error_code error, std::string_view request, std::chrono::nanoseconds took);
  Error note(Error error);
  std::string context(std::string_view message) const;

  asio::any_io_executor executor_;
  Clock& clock_;
  LinkSettings settings_;
  std::unique_ptr<ByteStream> stream_;
  asio::steady_timer deadline_, pause_;
  BackOff back_off_;
  std::chrono::steady_clock::time_point not_before_{};
  std::optional<Error> refusal_;  // why the device was not set up on the last connection
  std::string buffer_;            // received, not yet consumed
  enum class Interruption { none, timeout, aborted } interruption_ = Interruption::none;
  std::string abort_reason_;
  std::uint64_t timer_id_ = 0;
  bool busy_ = false, connected_ = false, in_step_ = true;
  bool has_answered_ = false, is_set_up_ = false;  // on this connection
  std::int64_t generation_ = 0, lost_steps_ = 0;
  DeviceHealth health_;
  ExchangeLog log_;
  std::shared_ptr<char> alive_ =
      std::make_shared<char>();  // timer handlers may outlive this object
};

}  // namespace driftwise::transport
