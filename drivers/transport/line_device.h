#pragma once
// Base of a driver for one device on one text line: link settings, set-up after every new
// connection and whenever the device may have lost it (Link::is_set_up), identity that brings the
// line back in step.
//
// Mutual exclusion of calls to one device is the caller's (server/core/ports/device.h): one call at
// a time. Devices at one address, a serial line or a serial server, take turns: every call holds
// its Turn. All on the executor's thread.

#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/transport/address.h"
#include "drivers/transport/as_tuple.h"
#include "drivers/transport/link.h"
#include "drivers/transport/shared_line.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::transport {

// Format of one text line: terminator, resynchronisation, framing, serial settings.
struct LineFormat {
  std::string end_of_command = "\n";
  std::string resync_request;  // answered with the identity; see LinkSettings
  std::string resync_prefix = {};
  Framing framing = line_reply;
  SerialSettings serial = {};
  // A program behind a TCP address that answers each connection for itself: no serial line is
  // behind it, and nobody waits for another's turn.
  bool answers_each_connection = false;
  // Knows the answer to resync_request; empty: the line that know_identity() was given.
  std::function<bool(std::string_view line)> is_resync_reply = {};
};

// Port: the port of the device's role, such as Instrument.
template <class Port>
class LineDevice : public Port {
 public:
  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return link_.health(); }
  std::vector<std::string> recent_exchanges() const override { return link_.log().lines(); }
  Awaitable<Result<void>> prepare() override {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await take_turn());
    co_return Result<void>{};
  }
  void close() override { link_.close(); }

 protected:
  // shared: of the devices that are made together; nullptr: this one has its line for itself.
  LineDevice(DeviceDescription device, const Address& address, asio::any_io_executor executor,
             Clock& clock, const LineFormat& format, SharedByAddress* shared = nullptr)
      : device_(std::move(device)),
        clock_(clock),
        end_of_command_(format.end_of_command),
        timeout_(nanoseconds_from_s(device_.timeout_s)),
        lines_(lines_of(executor,
                        format.answers_each_connection && is_tcp(address) ? nullptr : shared)),
        is_behind_tcp_(is_tcp(address)),
        key_(address, device_.address),
        link_(executor, clock, settings_of(format), make_stream(executor, address, format.serial)) {
  }

  // Makes a device ready that has just been connected, or may have lost its set-up; in step. Calls
  // know_identity().
  virtual Awaitable<Result<void>> set_up() = 0;

  // The line is this device's as long as it lives: to the end of a call.
  class [[nodiscard]] Turn {
   public:
    Turn(LineDevice& device, std::shared_ptr<SharedLine> line, AsyncMutex::Lock lock)
        : device_(&device),
          line_(std::move(line)),
          lock_(std::move(lock)),
          lost_steps_(device.link_.lost_steps()) {}
    Turn(Turn&& other) noexcept
        : device_(std::exchange(other.device_, nullptr)),
          line_(std::move(other.line_)),
          lock_(std::move(other.lock_)),
          lost_steps_(other.lost_steps_) {}
    Turn& operator=(Turn&&) = delete;
    ~Turn() {
      if (device_ == nullptr) return;
      if (device_->link_.lost_steps() != lost_steps_) ++line_->disturbances;
      device_->disturbances_seen_ = line_->disturbances;
      line_->last_user = device_;
      line_->last_end = std::chrono::steady_clock::now();
    }

   private:
    LineDevice* device_;
    std::shared_ptr<SharedLine> line_;
    AsyncMutex::Lock lock_;
    std::int64_t lost_steps_;
  };

  // Connected and set up, and nobody else's turn: at the beginning of every call, which keeps what
  // it gets.
  Awaitable<Result<Turn>> take_turn() {
    for (;;) {
      const auto key = key_.now(link_.peer_key());
      const auto line = lines_->at(key);
      if (std::exchange(line_, line) != line) disturbances_seen_ = line->disturbances;
      auto lock = co_await line->turn.lock();
      // An answer to another device of this line may still come, and what made that one late may
      // have reset ours.
      if (disturbances_seen_ != line->disturbances && link_.connected()) {
        link_.lose_set_up();
        if (resyncs_)
          link_.lose_step();
        else
          link_.close();
      }
      co_await let_copies_arrive(*line);
      Turn turn(*this, line, std::move(lock));
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await link_.connect(timeout_));
      // Which line it is may be known only now.
      if (key_.now(link_.peer_key()) != key) continue;
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready());
      co_return turn;
    }
  }
  // A serial server sends what another device was answered to this connection as well, a moment
  // later or earlier. What has arrived when a question is asked is thrown away.
  Awaitable<void> let_copies_arrive(const SharedLine& line) {
    if (!is_behind_tcp_ || line.last_user == nullptr || line.last_user == this) co_return;
    asio::steady_timer pause(co_await asio::this_coro::executor, line.last_end + kShortestTimeout);
    (void)co_await pause.async_wait(kAsTuple);
  }
  Awaitable<Result<void>> get_ready() {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await link_.connect(timeout_));
    if (is_set_up()) co_return Result<void>{};
    co_return co_await set_up_or_drop();
  }
  bool is_set_up() const { return link_.is_set_up(); }
  // False while a device is set up again on the connection on which it was set up before.
  bool is_new_connection() const { return link_.generation() != set_up_generation_; }
  // A device that could not be set up is connected anew. Not after a stop: it came in between.
  Awaitable<Result<void>> set_up_or_drop() {
    // By the identity that is known, before set_up() asks for it: with that answer under way as
    // well the first of two equal ones would be taken for the last.
    if (!identity_line_.empty() && !is_new_connection())
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await link_.get_in_step(timeout_));
    identity_line_.clear();
    auto done = co_await set_up();
    if (done) {
      set_up_generation_ = link_.generation();
      link_.device_is_set_up();
    } else if (link_.connected() && done.error().code != ErrorCode::aborted) {
      link_.drop(done.error());
    }
    co_return done;
  }

  // text: for people. reply: what the resync request is answered with.
  void know_identity(std::string text, std::string_view reply) {
    identity_line_ = without_line_ends(reply);
    link_.set_identity(std::move(text));
  }

  Awaitable<Result<std::string>> ask(std::string command) {
    return link_.ask(command + end_of_command_, timeout_);
  }
  Awaitable<Result<void>> tell(std::string command) {
    return link_.tell(command + end_of_command_, timeout_);
  }
  // The codec's error about the last answer. A refusal is in step with us, nonsense is not.
  template <class T>
  tl::unexpected<Error> wrong(const Result<T>& parsed) {
    if (parsed.error().reason == reasons::kBadReply) link_.lose_step();
    return link_.wrong_reply(parsed.error());
  }

  const DeviceDescription device_;
  Clock& clock_;
  const std::string end_of_command_;
  const Nanoseconds timeout_;

 private:
  LinkSettings settings_of(const LineFormat& format) {
    resyncs_ = !format.resync_request.empty();
    LinkSettings out;
    out.device = device_.id;
    out.address = device_.address;
    out.framing = format.framing;
    out.resync_prefix = format.resync_prefix;
    out.resync_request = format.resync_request;
    out.is_resync_reply = format.is_resync_reply;
    if (!out.is_resync_reply)
      out.is_resync_reply = [this](std::string_view reply) {
        return !identity_line_.empty() && reply == identity_line_;
      };
    return out;
  }

  static bool is_tcp(const Address& address) { return std::holds_alternative<TcpAddress>(address); }

  const std::shared_ptr<SharedLines> lines_;
  const bool is_behind_tcp_;
  LineKey key_;
  std::shared_ptr<SharedLine> line_;  // of the last turn
  std::string identity_line_;
  bool resyncs_ = false;
  std::int64_t set_up_generation_ = 0;  // connection on which it was last set up
  std::int64_t disturbances_seen_ = 0;

 protected:
  Link link_;
};

// The answer of an instrument that has no zero to set. why: "an autocollimator's angle is absolute"
inline tl::unexpected<Error> no_zero(const DeviceDescription& device, const std::string& why) {
  return fail(ErrorCode::failed_precondition, reasons::kNoZero,
              "device '" + device.id + "': " + why);
}

}  // namespace driftwise::transport
