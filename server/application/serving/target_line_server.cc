#include "server/application/serving/target_line_server.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <charconv>
#include <cstring>
#include <set>

#include "server/compensation/target.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/export/target_line.h"

namespace driftwise::application {
namespace {

using asio::ip::tcp;
using boost::system::error_code;
using WallClock = std::chrono::steady_clock;

Result<tcp::endpoint> endpoint_from(const std::string& address) {
  const auto bad = [&] {
    return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
                "target_line: found '" + address + "', expected host:port such as 127.0.0.1:50052");
  };
  const auto colon = address.rfind(':');
  if (colon == std::string::npos) return bad();
  std::string host = address.substr(0, colon);
  std::uint16_t port = 0;
  const char* end = address.data() + address.size();
  const auto [after, code] = std::from_chars(address.data() + colon + 1, end, port);
  if (code != std::errc{} || after != end) return bad();
  if (host == "localhost") host = "127.0.0.1";
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  error_code error;
  const auto ip = asio::ip::make_address(host, error);
  if (error) return bad();
  if (!ip.is_loopback())
    return fail(ErrorCode::failed_precondition, reasons::kListenNotLoopback,
                "target_line: found '" + address + "', expected an address on loopback");
  return tcp::endpoint(ip, port);
}

// A peer that vanished is noticed after about a minute and a half.
void watch_peer(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const auto set = [&](int name, int value) {
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, name, &value, sizeof value);
  };
  set(TCP_KEEPIDLE, 30);
  set(TCP_KEEPINTVL, 20);
  set(TCP_KEEPCNT, 3);
}

}  // namespace

// Owns the acceptor and knows the sessions; they keep it alive, and board and clock are null once
// it is shut.
class TargetLineServer::Door : public std::enable_shared_from_this<Door> {
 public:
  class Session;

  Door(tcp::acceptor acceptor, std::string address, const compensation::SnapshotBoard& board,
       const Clock& clock)
      : acceptor_(std::move(acceptor)),
        pause_(acceptor_.get_executor()),
        address_(std::move(address)),
        board_(&board),
        clock_(&clock) {}

  void accept_next();
  void shut();
  const std::string& address() const { return address_; }
  std::size_t clients() const { return sessions_.size(); }
  bool is_shut() const { return board_ == nullptr; }
  void answer(std::string_view line, std::string& out) const;
  void forget(Session* session) { sessions_.erase(session); }

 private:
  bool make_room();

  tcp::acceptor acceptor_;
  asio::steady_timer pause_;
  std::string address_;
  const compensation::SnapshotBoard* board_;
  const Clock* clock_;
  std::set<Session*> sessions_;
};

// One connection: read what is there, answer every whole line of it in one write, read on. While an
// answer is not yet taken nothing is read, so a client that does not listen costs one buffer.
class TargetLineServer::Door::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(tcp::socket socket, std::shared_ptr<Door> door)
      : socket_(std::move(socket)), door_(std::move(door)) {
    out_.reserve(formats::kMaxTargetAnswer);
  }
  ~Session() { door_->forget(this); }

  void read_on() {
    socket_.async_read_some(asio::buffer(in_.data() + filled_, in_.size() - filled_),
                            [self = shared_from_this()](error_code error, std::size_t count) {
                              self->on_read(error, count);
                            });
  }
  void refuse(Reason reason, const char* message) {
    formats::append_error_answer(out_, {ErrorCode::resource_exhausted, reason, message});
    last_ = true;
    write();
  }
  void close() {
    last_ = true;
    door_->forget(this);  // its place is free at once, whenever the last handler lets go of it
    error_code ignored;
    socket_.close(ignored);
  }
  // Since when it asked for nothing and took no answer.
  WallClock::time_point idle_since() const { return active_; }

 private:
  void on_read(error_code error, std::size_t count) {
    if (error || door_->is_shut() || last_) return;  // the last owner goes with the handler
    filled_ += count;
    active_ = WallClock::now();
    std::size_t start = 0;
    while (const void* end = std::memchr(in_.data() + start, '\n', filled_ - start)) {
      const auto length =
          static_cast<std::size_t>(static_cast<const char*>(end) - in_.data()) - start;
      std::string_view line(in_.data() + start, length);
      if (line.ends_with('\r')) line.remove_suffix(1);
      door_->answer(line, out_);
      start += length + 1;
    }
    std::memmove(in_.data(), in_.data() + start, filled_ - start);
    filled_ -= start;
    if (filled_ >= formats::kMaxTargetLine)
      return refuse(reasons::kLineTooLong, "no end within 512 bytes: the connection is closed");
    out_.empty() ? read_on() : write();
  }
  void write() {
    asio::async_write(socket_, asio::buffer(out_),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (error || self->last_ || self->door_->is_shut()) return self->close();
                        self->active_ = WallClock::now();
                        self->out_.clear();
                        self->read_on();
                      });
  }

  tcp::socket socket_;
  std::shared_ptr<Door> door_;
  std::array<char, 2048> in_;
  std::size_t filled_ = 0;
  std::string out_;
  WallClock::time_point active_ = WallClock::now();
  bool last_ = false;
};

bool TargetLineServer::Door::make_room() {
  if (sessions_.size() < kMaxClients) return true;
  const auto oldest = std::min_element(
      sessions_.begin(), sessions_.end(),
      [](const Session* a, const Session* b) { return a->idle_since() < b->idle_since(); });
  if (WallClock::now() - (*oldest)->idle_since() < kIdle) return false;
  (*oldest)->close();
  return true;
}

void TargetLineServer::Door::accept_next() {
  acceptor_.async_accept([self = shared_from_this()](error_code error, tcp::socket socket) {
    if (self->is_shut()) return;
    if (!error) {
      watch_peer(socket);
      const bool room = self->make_room();
      auto session = std::make_shared<Session>(std::move(socket), self);
      self->sessions_.insert(session.get());
      if (room)
        session->read_on();
      else
        session->refuse(reasons::kTooManyClients, "64 connections are at work: close one first");
    }
    if (!error) return self->accept_next();
    // Out of descriptors, for one: a new attempt at once would fail at once, again and again.
    self->pause_.expires_after(std::chrono::milliseconds(100));
    self->pause_.async_wait([self](error_code stopped) {
      if (!stopped && !self->is_shut()) self->accept_next();
    });
  });
}

void TargetLineServer::Door::shut() {
  board_ = nullptr;
  clock_ = nullptr;
  error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
  const auto open = sessions_;
  for (auto* session : open) session->close();
}

void TargetLineServer::Door::answer(std::string_view line, std::string& out) const {
  auto request = formats::parse_target_line(line);
  if (!request) return formats::append_error_answer(out, request.error());
  request->now = clock_->now().utc;
  const auto snapshot = board_->read();
  static const compensation::Snapshot kNone;  // no model: refused as such
  const auto& present = snapshot ? *snapshot : kNone;
  auto target = compensation::compute_target(present, *request);
  target.valid_until = {clock_->utc(target.valid_until).ns};  // the wire has UTC
  formats::append_target_answer(out, present, target, request->with_uncertainty);
}

Result<std::unique_ptr<TargetLineServer>> TargetLineServer::start(
    asio::any_io_executor executor, const std::string& address,
    const compensation::SnapshotBoard& board, const Clock& clock) {
  DRIFTWISE_TRY(const auto endpoint, endpoint_from(address));
  tcp::acceptor acceptor(executor);
  error_code error;
  const auto attempt = [&](auto&& step) {
    if (!error) step();
  };
  attempt([&] { acceptor.open(endpoint.protocol(), error); });
  attempt([&] { acceptor.set_option(tcp::acceptor::reuse_address(true), error); });
  attempt([&] { acceptor.bind(endpoint, error); });
  attempt([&] { acceptor.listen(asio::socket_base::max_listen_connections, error); });
  if (error)
    return fail(ErrorCode::unavailable, reasons::kCannotListen,
                "cannot listen on " + address + " for target lines: " + error.message() +
                    "; choose another port in [cell] target_line");
  const auto local = acceptor.local_endpoint(error);
  const std::string host = local.address().is_v6() ? "[" + local.address().to_string() + "]"
                                                   : local.address().to_string();
  auto door = std::make_shared<Door>(std::move(acceptor), host + ":" + std::to_string(local.port()),
                                     board, clock);
  door->accept_next();
  return std::unique_ptr<TargetLineServer>(new TargetLineServer(std::move(door)));
}

TargetLineServer::TargetLineServer(std::shared_ptr<Door> door) : door_(std::move(door)) {}
TargetLineServer::~TargetLineServer() { stop(); }
const std::string& TargetLineServer::address() const { return door_->address(); }
std::size_t TargetLineServer::clients() const { return door_->clients(); }
void TargetLineServer::stop() {
  if (!door_->is_shut()) door_->shut();
}

}  // namespace driftwise::application
