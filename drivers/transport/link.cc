#include "drivers/transport/link.h"

#include <cstdio>

#include "drivers/transport/as_tuple.h"
#include "drivers/transport/escape.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::transport {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr int kMaxStaleReplies = 256;

std::string milliseconds(std::chrono::nanoseconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f ms", static_cast<double>(time.count()) * 1e-6);
  return text;
}

}  // namespace

// Marks the link busy for the life of one call, even if that is unwound by a cancelled coroutine.
class Link::Running {
 public:
  explicit Running(Link& link) : link_(link) {
    link_.busy_ = true;
    link_.interruption_ = Interruption::none;
  }
  ~Running() {
    ++link_.timer_id_;
    link_.deadline_.cancel();
    link_.busy_ = false;
    if (finished_) return;
    link_.in_step_ = false;
    ++link_.lost_steps_;
  }
  Running(const Running&) = delete;
  void finish() { finished_ = true; }

 private:
  Link& link_;
  bool finished_ = false;
};

Link::Link(asio::any_io_executor executor, Clock& clock, LinkSettings settings,
           std::unique_ptr<ByteStream> stream)
    : executor_(executor),
      clock_(clock),
      settings_(std::move(settings)),
      stream_(std::move(stream)),
      deadline_(executor),
      pause_(executor),
      back_off_(seed_from(settings_.device + settings_.address), settings_.back_off) {}

Link::~Link() = default;

void Link::start_timer(std::chrono::nanoseconds limit) {
  deadline_.expires_after(limit);
  deadline_.async_wait(
      [this, id = ++timer_id_, alive = std::weak_ptr<char>(alive_)](error_code error) {
        if (error || alive.expired() || id != timer_id_) return;
        interruption_ = Interruption::timeout;
        stream_->cancel();
      });
}

Awaitable<Result<void>> Link::connect(Nanoseconds timeout) {
  if (busy_) co_return fail(ErrorCode::internal, reasons::kBusy, context("two calls at once"));
  if (connected_ && still_there()) co_return Result<void>{};
  Running running(*this);
  const auto limit = clock_.wall_from(timeout, kShortestTimeout);
  if (const auto wait = not_before_ - SteadyClock::now(); wait > wait.zero()) {
    pause_.expires_after(std::min<SteadyClock::duration>(wait, limit));
    (void)co_await pause_.async_wait(kAsTuple);
    if (interruption_ == Interruption::aborted)
      co_return fail(ErrorCode::aborted, abort_reason_,
                     context("stopped while waiting to reconnect"));
    if (wait > limit) {
      if (refusal_) co_return tl::unexpected(*refusal_);
      co_return fail(ErrorCode::unavailable, reasons::kLinkDown,
                     context("not connected, next attempt in " + milliseconds(wait - limit) +
                             "; last error: " + health_.last_error));
    }
  }
  health_.link = LinkState::connecting;
  const auto started = SteadyClock::now();
  start_timer(limit);
  const error_code error = co_await stream_->open();
  if (!error && interruption_ == Interruption::none) {
    connected_ = in_step_ = true;
    has_answered_ = is_set_up_ = false;
    buffer_.clear();
    if (generation_++ > 0) ++health_.reconnects;
    health_.link = LinkState::connected;
    running.finish();
    co_return Result<void>{};
  }
  if (interruption_ == Interruption::aborted) {
    // No failure of the device: nothing to back off from, and no error to show.
    disconnect(LinkState::disconnected);
    co_return fail(ErrorCode::aborted, abort_reason_, context("stopped while connecting"));
  }
  const std::string why = interruption_ == Interruption::timeout
                              ? "no connection within " + milliseconds(SteadyClock::now() - started)
                              : "cannot connect: " + error.message();
  drop(why);
  co_return tl::unexpected(note({ErrorCode::unavailable, reasons::kLinkDown,
                                 context(why + ": is it on, and is the address right?")}));
}

Awaitable<Result<std::string>> Link::ask(std::string request, Nanoseconds timeout, int replies) {
  if (busy_) co_return fail(ErrorCode::internal, reasons::kBusy, context("two calls at once"));
  if (!connected_)
    co_return fail(ErrorCode::unavailable, reasons::kLinkDown, context("not connected"));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_in_step(timeout));
  co_return co_await talk(std::move(request), timeout, replies);
}

Awaitable<Result<void>> Link::tell(std::string command, Nanoseconds timeout) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await ask(std::move(command), timeout, 0));
  co_return Result<void>{};
}

Awaitable<Result<void>> Link::await_silence(Nanoseconds silence) {
  if (busy_) co_return fail(ErrorCode::internal, reasons::kBusy, context("two calls at once"));
  if (!connected_)
    co_return fail(ErrorCode::unavailable, reasons::kLinkDown, context("not connected"));
  Running running(*this);
  const auto started = SteadyClock::now();
  char stale[256];
  for (int i = 0; i < kMaxStaleReplies; ++i) {
    start_timer(clock_.wall_from(silence, kShortestTimeout));
    const auto [error, count] = co_await stream_->read_some(stale);
    if (interruption_ == Interruption::aborted || (error && interruption_ == Interruption::none))
      co_return tl::unexpected(ended(error, "waiting for silence", SteadyClock::now() - started));
    if (count == 0) {
      running.finish();
      co_return Result<void>{};
    }
    interruption_ = Interruption::none;
    log_.add({health_.exchanges, "", std::string(stale, count), {}, "late, thrown away"});
  }
  drop("talks without end");
  co_return fail(ErrorCode::data_loss, reasons::kOutOfStep, context("talks without being asked"));
}

Awaitable<Result<std::string>> Link::talk(std::string request, Nanoseconds timeout, int replies) {
  Running running(*this);
  const bool there = still_there();  // drops stale bytes
  const auto started = SteadyClock::now();
  start_timer(clock_.wall_from(timeout, kShortestTimeout));
  ++health_.exchanges;

  // A line that the other side has closed meanwhile is closed here as well by now.
  error_code error = asio::error::connection_reset;
  if (there) error = (co_await stream_->write(request)).error;
  std::size_t length = 0;  // of the complete replies at the front of buffer_
  while (!error && interruption_ == Interruption::none) {
    while (replies > 0) {
      const std::size_t next = settings_.framing(std::string_view(buffer_).substr(length));
      if (next == kIncomplete) break;
      length += next;
      --replies;
    }
    if (replies == 0) break;
    if (buffer_.size() > settings_.max_reply_bytes) {
      error = asio::error::message_size;
      break;
    }
    const std::size_t had = buffer_.size();
    buffer_.resize(had + 4096);
    const auto [read_error, count] = co_await stream_->read_some(std::span(buffer_).subspan(had));
    buffer_.resize(had + count);
    error = read_error;
  }
  const auto took = SteadyClock::now() - started;
  health_.last_latency_s = static_cast<double>(std::chrono::nanoseconds(took).count()) * 1e-9;
  Exchange exchange{health_.exchanges, request,
                    buffer_.substr(0, replies == 0 ? length : buffer_.size()), took, ""};
  if (replies > 0 || error) {
    log_.add(exchange);
    Error failure = ended(error, describe(exchange), took);
    co_return tl::unexpected(std::move(failure));
  }
  running.finish();
  health_.last_good = clock_.now().utc;
  has_answered_ = true;
  if (is_set_up_) back_off_.after_success();
  std::string reply = buffer_.substr(0, length);
  buffer_.erase(0, length);
  log_.add(std::move(exchange));
  co_return reply;
}

// Why an exchange ended without its answer. Whatever came of it is thrown away.
Error Link::ended(error_code error, std::string_view exchange, std::chrono::nanoseconds took) {
  buffer_.clear();
  const std::string what(exchange);
  if (error == asio::error::message_size) {
    drop("reply too long");
    return note(
        {ErrorCode::data_loss, reasons::kReplyTooLong,
         context(what + ": no end of reply within " + std::to_string(settings_.max_reply_bytes) +
                 " bytes; check framing and baud rate")});
  }
  if (interruption_ == Interruption::aborted) {
    return note({ErrorCode::aborted, abort_reason_, context(what + ": stopped")});
  }
  if (interruption_ == Interruption::timeout) {
    is_set_up_ = false;
    if (settings_.resync_request.empty()) drop("no answer in time");
    return note({ErrorCode::deadline_exceeded, reasons::kTimeout,
                 context(what + ": no complete reply within " + milliseconds(took))});
  }
  drop(error.message());
  return note({ErrorCode::unavailable, reasons::kLinkLost, context(what + ": " + error.message())});
}

Awaitable<Result<void>> Link::get_in_step(Nanoseconds timeout) {
  if (in_step_) co_return Result<void>{};
  if (settings_.resync_request.empty()) {
    drop("out of step");
    co_return fail(ErrorCode::unavailable, reasons::kLinkLost,
                   context("out of step after a failed exchange; reconnecting"));
  }
  std::string request = settings_.resync_prefix + settings_.resync_request;
  for (int stale = 0; stale < kMaxStaleReplies; ++stale) {
    auto reply = co_await talk(std::move(request), timeout, 1);
    if (!reply) {
      if (reply.error().code != ErrorCode::aborted)
        drop("does not answer '" + settings_.resync_request + "'");
      co_return tl::unexpected(reply.error());
    }
    if (settings_.is_resync_reply(without_line_ends(*reply))) {
      in_step_ = true;
      co_return Result<void>{};
    }
    request.clear();  // only read on
  }
  drop("talks without end");
  co_return fail(ErrorCode::data_loss, reasons::kOutOfStep, context("talks without being asked"));
}

// Throws away what came without being asked for; false when the other side has closed the line.
bool Link::still_there() {
  if (in_step_) buffer_.clear();
  char stale[4096];
  for (int i = 0; i < 64 && in_step_; ++i) {
    const auto [error, count] = stream_->read_now(stale);
    if (error == asio::error::would_block || error == asio::error::try_again) return true;
    if (error) {
      drop("closed by the other side: " + error.message());
      return false;
    }
    log_.add({health_.exchanges, "", std::string(stale, count), {}, "not asked for, thrown away"});
  }
  return true;
}

void Link::device_is_set_up() {
  is_set_up_ = true;
  health_.last_error.clear();  // not before: a line may connect to a device that is switched off
  if (has_answered_) back_off_.after_success();
}

error_code Link::interrupt(std::string_view bytes, std::string why) {
  const error_code error = write_now(bytes);
  not_before_ = {};
  in_step_ = false;
  if (busy_) {
    interruption_ = Interruption::aborted;
    abort_reason_ = std::move(why);
    pause_.cancel();
    stream_->cancel();
  }
  return error;
}

error_code Link::write_now(std::string_view bytes) {
  return connected_ && !bytes.empty() ? stream_->write_now(bytes) : error_code{};
}

void Link::drop(const Error& refusal) {
  drop(refusal.message);
  refusal_ = refusal;
}

void Link::drop(const std::string& why) {
  disconnect(LinkState::failed);
  health_.last_error = why;
  not_before_ = SteadyClock::now() + back_off_.after_failure();
}

void Link::disconnect(LinkState state) {
  refusal_.reset();
  connected_ = is_set_up_ = false;
  in_step_ = true;
  stream_->close();
  buffer_.clear();
  health_.link = state;
}

void Link::close() {
  interrupt({}, reasons::kClosed);
  disconnect(LinkState::disconnected);
}

tl::unexpected<Error> Link::wrong_reply(const Error& error) {
  const std::string exchange = log_.entries().empty() ? "" : describe(log_.entries().back()) + ": ";
  return tl::unexpected(note({error.code, error.reason, context(exchange + error.message)}));
}

tl::unexpected<Error> Link::refused(std::string reason, const std::string& message) {
  return wrong_reply({ErrorCode::failed_precondition, std::move(reason), message});
}

Error Link::note(Error error) {
  ++health_.errors;
  health_.last_error = error.message;
  return error;
}

std::string Link::context(std::string_view message) const {
  return "device '" + settings_.device + "' at " + settings_.address + ": " + std::string(message);
}

}  // namespace driftwise::transport
