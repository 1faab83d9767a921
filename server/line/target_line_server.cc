#include "server/line/target_line_server.h"

#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstring>
#include <set>

#include "server/access/failed_handshakes.h"
#include "server/access/peer_name.h"
#include "server/access/wrong_tries.h"
#include "server/compensation/target.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/export/target_line.h"
#include "server/line/line_address.h"
#include "server/line/line_listener.h"
#include "server/line/line_socket.h"
#include "server/plans/joint_target.h"

namespace driftwise::line {
namespace {

using asio::ip::tcp;
using boost::system::error_code;
using WallClock = std::chrono::steady_clock;

constexpr int kMostUnknownLines = 16;  // of a client that does not say who it is
constexpr int kMostSearches = 8;       // of arms' joints, that wait for the background thread

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

const char* key_of(LineKind kind) {
  if (kind == LineKind::loopback) return "[cell] target_line";
  return kind == LineKind::tls ? "[access] target_line" : "[access] plain_target_line";
}

}  // namespace

// Owns the acceptor and knows the sessions; they keep it alive, and what it borrows is not touched
// any more once it is shut.
class TargetLineServer::Door : public std::enable_shared_from_this<Door> {
 public:
  class Session;

  Door(std::shared_ptr<LineListener> listener, AddressList allowed, LineParts parts, LineDoor door)
      : listener_(std::move(listener)),
        address_(text_of(listener_->endpoint())),
        allowed_(std::move(allowed)),
        parts_(std::move(parts)),
        door_(std::move(door)),
        failed_handshakes_("text line " + address_) {}

  void begin();
  void shut();
  const std::string& address() const { return address_; }
  std::size_t clients() const { return sessions_.size(); }
  std::size_t turned_away() const { return turned_away_; }
  bool is_shut() const { return listener_->is_shut(); }
  // False: an arm's joints are searched for, and the answer comes back by Session::on_answer().
  bool answer(std::string_view line, std::string& out, const std::shared_ptr<Session>& session);
  void answer_joint(std::string_view line, std::string& out) const;
  void forget(Session* session) { sessions_.erase(session); }
  void tell_failed_handshake(const std::string& from, error_code why);
  LineRights rights(const tcp::endpoint& peer) const {
    return {parts_.access, door_.kind, access::peer_name_of(*peer.data())};
  }
  // Checks the token where that may take its time, and comes back.
  void identify(access::Evidence evidence, std::shared_ptr<Session> session) const;

 private:
  void take(tcp::socket socket);
  bool make_room();
  void search(const compensation::Snapshot& present, const compensation::TargetRequest& request,
              std::shared_ptr<Session> session);

  std::shared_ptr<LineListener> listener_;
  std::string address_;
  AddressList allowed_;
  LineParts parts_;
  LineDoor door_;
  int searches_ = 0;
  std::size_t turned_away_ = 0;
  WallClock::time_point told_{};
  access::FailedHandshakes failed_handshakes_;
  std::set<Session*> sessions_;
};

// One connection: read what is there, answer every whole line of it in one write, read on. While an
// answer is not yet taken, a token is looked at or an arm's joints are searched for, nothing is
// read, so a client that does not listen costs one buffer.
class TargetLineServer::Door::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(std::unique_ptr<LineSocket> socket, LineRights rights, std::shared_ptr<Door> door)
      : socket_(std::move(socket)),
        rights_(std::move(rights)),
        door_(std::move(door)),
        limit_(door_->parts_.executor) {
    out_.reserve(formats::kMaxTargetAnswer);
  }
  ~Session() { door_->forget(this); }

  void begin() {
    close_after(kHandshake);
    socket_->shake_hands([self = shared_from_this()](error_code error) {
      if (error) self->door_->tell_failed_handshake(self->rights_.from(), error);
      if (error || self->door_->is_shut() || self->last_) return self->close();
      if (const auto entered = self->rights_.take(self->socket_->certificate()); !entered)
        return self->refuse(entered.error());
      self->limit_.cancel();
      if (!self->rights_.known()) self->close_after(kUnknown);
      self->read_on();
    });
  }
  void refuse(const Error& error) {
    formats::append_error_answer(out_, error);
    last_ = true;
    write();
  }
  void close() {
    last_ = true;
    door_->forget(this);  // its place is free at once, whenever the last handler lets go of it
    limit_.cancel();
    socket_->close();
  }
  // Since when it asked for nothing and took no answer.
  WallClock::time_point idle_since() const { return active_; }
  bool known() const { return rights_.known(); }

  void on_identity(Result<access::Identity> who) {
    if (door_->is_shut() || last_) return;
    active_ = WallClock::now();
    checking_ = false;
    token_.clear();
    if (who) {
      out_ += "OK name=" + one_word(who->name) +
              " role=" + std::string(access::to_string(who->role)) + "\n";
      rights_.take(std::move(*who));
      limit_.cancel();
    } else {
      formats::append_error_answer(out_, who.error());
      // Whoever has to wait does so without a place here.
      last_ = who.error().code == ErrorCode::resource_exhausted || ++unknown_lines_ >= 3;
    }
    if (last_) return write();
    go_on();
  }
  void on_answer(std::string_view text) {
    if (last_) return;
    active_ = WallClock::now();
    checking_ = false;
    out_ += text;
    go_on();
  }

 private:
  // Blanks would part it: a name is one word of the answer.
  static std::string one_word(std::string name) {
    for (char& c : name)
      if (c == ' ') c = '_';
    return name;
  }
  void close_after(std::chrono::seconds limit) {
    limit_.expires_after(limit);
    limit_.async_wait([weak = weak_from_this()](error_code cancelled) {
      if (const auto self = weak.lock(); self && !cancelled) self->close();
    });
  }
  void read_on() {
    socket_->read_some(std::span(in_).subspan(filled_),
                       [self = shared_from_this()](error_code error, std::size_t count) {
                         self->on_read(error, count);
                       });
  }
  void on_read(error_code error, std::size_t count) {
    if (error || door_->is_shut() || last_) return;  // the last owner goes with the handler
    filled_ += count;
    active_ = WallClock::now();
    go_on();
  }
  // Every whole line, until one has to wait.
  void go_on() {
    std::size_t start = 0;
    while (!checking_ && !last_) {
      const void* end = std::memchr(in_.data() + start, '\n', filled_ - start);
      if (end == nullptr) break;
      const auto length =
          static_cast<std::size_t>(static_cast<const char*>(end) - in_.data()) - start;
      std::string_view line(in_.data() + start, length);
      if (line.ends_with('\r')) line.remove_suffix(1);
      take(line);
      start += length + 1;
    }
    std::memmove(in_.data(), in_.data() + start, filled_ - start);
    filled_ -= start;
    if (last_) return write();
    if (checking_) return;  // what follows stays where it is
    if (filled_ >= formats::kMaxTargetLine)
      return refuse({ErrorCode::resource_exhausted, reasons::kLineTooLong,
                     "no end within 512 bytes: the connection is closed"});
    out_.empty() ? read_on() : write();
  }
  void take(std::string_view line) {
    if (line.starts_with("TOKEN ") && line.size() < formats::kMaxTargetLine) {
      token_ = std::string(line.substr(6));
      checking_ = true;
      return door_->identify(rights_.evidence_of(token_), shared_from_this());
    }
    if (const auto may = rights_.may_ask(); !may) {
      formats::append_error_answer(out_, may.error());
      last_ = !rights_.known() && ++unknown_lines_ >= kMostUnknownLines;
      return;
    }
    checking_ = !door_->answer(line, out_, shared_from_this());
  }
  void write() {
    socket_->write(out_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error || self->last_ || self->door_->is_shut()) return self->close();
      self->active_ = WallClock::now();
      self->out_.clear();
      self->read_on();
    });
  }

  std::unique_ptr<LineSocket> socket_;
  LineRights rights_;
  std::shared_ptr<Door> door_;
  asio::steady_timer limit_;
  std::array<char, 2048> in_;
  std::size_t filled_ = 0;
  std::string out_, token_;
  WallClock::time_point active_ = WallClock::now();
  int unknown_lines_ = 0;
  bool checking_ = false, last_ = false;
};

bool TargetLineServer::Door::make_room() {
  if (sessions_.size() < kMaxClients) return true;
  const auto first =
      std::min_element(sessions_.begin(), sessions_.end(), [](const Session* a, const Session* b) {
        return std::pair(a->known(), a->idle_since()) < std::pair(b->known(), b->idle_since());
      });
  if ((*first)->known() && WallClock::now() - (*first)->idle_since() < kIdle) return false;
  (*first)->close();
  return true;
}

void TargetLineServer::Door::begin() {
  listener_->begin([door = weak_from_this()](tcp::socket socket) {
    if (const auto self = door.lock()) self->take(std::move(socket));
  });
}

void TargetLineServer::Door::take(tcp::socket socket) {
  error_code gone;
  const auto peer = socket.remote_endpoint(gone);
  if (gone) return;
  if (door_.kind == LineKind::plain_network && !allowed_.holds(peer.address())) {
    ++turned_away_;
    if (const auto now = WallClock::now(); now - told_ >= std::chrono::minutes(1)) {
      told_ = now;
      spdlog::warn("text line {}: {} is not in plain_allow, {} were turned away so far", address_,
                   peer.address().to_string(), turned_away_);
    }
    return;  // closed without a word
  }
  watch_peer(socket);
  const bool room = make_room();
  auto session = std::make_shared<Session>(
      LineSocket::make(std::move(socket), door_.tls ? door_.tls->context() : nullptr), rights(peer),
      shared_from_this());
  sessions_.insert(session.get());
  if (room) return session->begin();
  // Behind TLS there is nobody to say it to yet.
  if (door_.kind == LineKind::tls) return session->close();
  session->refuse({ErrorCode::resource_exhausted, reasons::kTooManyClients,
                   "64 connections are at work: close one first"});
}

void TargetLineServer::Door::identify(access::Evidence evidence,
                                      std::shared_ptr<Session> session) const {
  access::Access* access = &parts_.access;
  asio::post(parts_.background, [access, evidence = std::move(evidence), session,
                                 executor = parts_.executor]() mutable {
    auto who = access->authoriser().identify(evidence);
    asio::post(executor, [session = std::move(session), who = std::move(who)]() mutable {
      session->on_identity(std::move(who));
    });
  });
}

void TargetLineServer::Door::tell_failed_handshake(const std::string& from, error_code why) {
  if (why.category() != asio::error::get_ssl_category()) return;  // it only left
  const auto line =
      failed_handshakes_.note(access::source_of(from), why.message(), WallClock::now());
  if (line) spdlog::warn("{}", *line);
}

void TargetLineServer::Door::shut() {
  listener_->shut();
  const auto open = sessions_;
  for (auto* session : open) session->close();
}

bool TargetLineServer::Door::answer(std::string_view line, std::string& out,
                                    const std::shared_ptr<Session>& session) {
  if (line.starts_with("JOINT")) {
    answer_joint(line, out);
    return true;
  }
  auto request = formats::parse_target_line(line);
  if (!request) {
    formats::append_error_answer(out, request.error());
    return true;
  }
  request->now = parts_.clock.now().utc;
  const auto snapshot = parts_.board.read();
  static const compensation::Snapshot kNone;  // no model: refused as such
  const auto& present = snapshot ? *snapshot : kNone;
  const bool searched = compensation::needs_search(present, *request);
  if (searched && searches_ < kMostSearches) {
    search(present, *request, session);
    return false;
  }
  if (searched) {
    formats::append_error_answer(
        out, {ErrorCode::resource_exhausted, reasons::kBusy,
              std::to_string(kMostSearches) +
                  " searches of an arm's joints are waiting, which is the most; ask again in a "
                  "moment, or state near_q1_deg and so on near the solution"});
    return true;
  }
  auto target = compensation::compute_target(present, *request);
  target.valid_until = {parts_.clock.utc(target.valid_until).ns};  // the wire has UTC
  formats::append_target_answer(out, present, target, request->with_uncertainty);
  return true;
}

// On the background thread, from a copy: whoever holds the board's snapshot holds up the writer.
void TargetLineServer::Door::search(const compensation::Snapshot& present,
                                    const compensation::TargetRequest& request,
                                    std::shared_ptr<Session> session) {
  ++searches_;
  asio::post(parts_.background, [door = shared_from_this(), session = std::move(session), request,
                                 kept = std::make_shared<const compensation::Snapshot>(present),
                                 executor = parts_.executor]() mutable {
    auto target = compensation::compute_target(*kept, request);
    asio::post(executor, [door = std::move(door), session = std::move(session), request,
                          kept = std::move(kept), target = std::move(target)]() mutable {
      --door->searches_;
      if (door->is_shut()) return;
      target.valid_until = {door->parts_.clock.utc(target.valid_until).ns};
      std::string text;
      formats::append_target_answer(text, *kept, target, request.with_uncertainty);
      session->on_answer(text);
    });
  });
}

void TargetLineServer::Door::answer_joint(std::string_view line, std::string& out) const {
  static const plans::JointSnapshot kNone;  // no plan: refused as such
  plans::JointBoard::Read snapshot;
  if (parts_.joint != nullptr) snapshot = parts_.joint->read();
  const auto& present = snapshot ? *snapshot : kNone;
  auto request = formats::parse_joint_line(line, present);
  if (!request) return formats::append_error_answer(out, request.error());
  request->now = parts_.clock.now().utc;
  auto target = plans::compute_joint_target(present, *request);
  target.valid_until = {parts_.clock.utc(target.valid_until).ns};  // the wire has UTC
  formats::append_joint_answer(out, present, target, request->with_uncertainty);
}

Result<std::unique_ptr<TargetLineServer>> TargetLineServer::start(LineParts parts, LineDoor door) {
  DRIFTWISE_TRY(const auto endpoint, endpoint_from(door.address));
  AddressList allowed;
  if (door.kind == LineKind::loopback && !endpoint.address().is_loopback())
    return fail(ErrorCode::failed_precondition, reasons::kListenNotLoopback,
                "target_line: found '" + door.address +
                    "', expected an address on loopback; for others [access] target_line speaks "
                    "TLS");
  if (door.kind == LineKind::plain_network) {
    DRIFTWISE_RETURN_IF_ERROR(check_interface(door.interface, endpoint.address()));
    DRIFTWISE_TRY(allowed, AddressList::from(door.allow));
  }
  auto listener = std::make_shared<LineListener>(
      parts.executor, endpoint,
      door.kind == LineKind::plain_network ? door.interface : std::string());
  if (const error_code error = listener->open())
    return fail(ErrorCode::unavailable, reasons::kCannotListen,
                "cannot listen on " + door.address + " for target lines: " + error.message() +
                    "; choose another port in " + key_of(door.kind));
  auto listening = std::make_shared<Door>(std::move(listener), std::move(allowed), std::move(parts),
                                          std::move(door));
  listening->begin();
  return std::unique_ptr<TargetLineServer>(new TargetLineServer(std::move(listening)));
}

TargetLineServer::TargetLineServer(std::shared_ptr<Door> door) : door_(std::move(door)) {}
TargetLineServer::~TargetLineServer() { stop(); }
const std::string& TargetLineServer::address() const { return door_->address(); }
std::size_t TargetLineServer::clients() const { return door_->clients(); }
std::size_t TargetLineServer::turned_away() const { return door_->turned_away(); }
void TargetLineServer::stop() {
  if (!door_->is_shut()) door_->shut();
}

}  // namespace driftwise::line
