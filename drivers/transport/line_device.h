#pragma once
// Base of a driver for one device on one text line: link settings, set-up after every new
// connection, identity that brings the line back in step.
//
// Mutual exclusion is the caller's (server/core/ports/device.h): one call at a time. All on the
// executor's thread.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/transport/address.h"
#include "drivers/transport/link.h"
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
  Awaitable<Result<void>> prepare() override { return get_ready(); }
  void close() override { link_.close(); }

 protected:
  LineDevice(DeviceDescription device, const Address& address, asio::any_io_executor executor,
             Clock& clock, const LineFormat& format)
      : device_(std::move(device)),
        clock_(clock),
        end_of_command_(format.end_of_command),
        timeout_(nanoseconds_from_s(device_.timeout_s)),
        link_(executor, clock, settings_of(format), make_stream(executor, address, format.serial)) {
  }

  // Makes a device ready that has just been connected. Calls know_identity().
  virtual Awaitable<Result<void>> set_up() = 0;

  // Connected and set up: at the beginning of every call.
  Awaitable<Result<void>> get_ready() {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await link_.connect(timeout_));
    if (is_set_up()) co_return Result<void>{};
    co_return co_await set_up_or_drop();
  }
  bool is_set_up() const { return link_.generation() == set_up_generation_; }
  // A device that could not be set up is connected anew. Not after a stop: it came in between.
  Awaitable<Result<void>> set_up_or_drop() {
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

  std::string identity_line_;
  std::int64_t set_up_generation_ = 0;

 protected:
  Link link_;
};

// The answer of an instrument that has no zero to set. why: "an autocollimator's angle is absolute"
inline tl::unexpected<Error> no_zero(const DeviceDescription& device, const std::string& why) {
  return fail(ErrorCode::failed_precondition, reasons::kNoZero,
              "device '" + device.id + "': " + why);
}

}  // namespace driftwise::transport
