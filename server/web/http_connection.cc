#include "server/web/http_connection.h"

#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_cat.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>

#include "server/access/peer_name.h"
#include "server/access/wrong_tries.h"
#include "server/web/security_headers.h"
#include "server/web/stop_socket.h"

namespace driftwise::web {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using std::chrono::seconds;
using Code = boost::system::error_code;
using WallClock = std::chrono::steady_clock;

constexpr std::size_t kMaxHeaderBytes = 16 * 1024;
constexpr auto kHandshakeLimit = seconds(10), kIdleLimit = seconds(75), kHeaderLimit = seconds(10),
               kBodyPauseLimit = seconds(20), kBodyLimit = seconds(300), kWriteLimit = seconds(60);

using Parser = http::request_parser<http::string_body>;

// What the connection itself says of each of its requests.
struct Ends {
  std::string peer, local;  // "ipv4:127.0.0.1:5020"; "127.0.0.1"
  bool secure = false;
};

HttpRequest head_of(const Parser& parser, const Ends& ends) {
  HttpRequest out;
  out.peer = ends.peer;
  out.local = ends.local;
  out.secure = ends.secure;
  out.method = std::string(parser.get().method_string());
  out.target = std::string(parser.get().target());
  for (const auto& field : parser.get()) {
    std::string name(field.name_string());
    for (char& c : name)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    out.headers.push_back({std::move(name), std::string(field.value())});
  }
  return out;
}

std::string peer_of(const tcp::socket& socket) {
  Code gone;
  const auto end = socket.remote_endpoint(gone);
  if (gone) return "unknown";
  return access::peer_name_of(*end.data());
}

std::string local_of(const tcp::socket& socket) {
  Code gone;
  const auto end = socket.local_endpoint(gone);
  return gone ? std::string() : access::address_text_of(*end.data());
}

// "ipv4:127.0.0.1:5020" -> "ipv4:127.0.0.1"
std::string without_port(const std::string& peer) { return peer.substr(0, peer.rfind(':')); }

// A peer that vanished is noticed after about a minute and a half.
void watch_peer(tcp::socket& socket) {
  Code ignored;
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const auto set = [&](int name, int value) {
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, name, &value, sizeof value);
  };
  set(TCP_KEEPIDLE, 30);
  set(TCP_KEEPINTVL, 20);
  set(TCP_KEEPCNT, 3);
}

HttpResponse refusal(Code why) {
  if (why == http::error::header_limit)
    return plain_answer(431, "the headers are longer than 16 KiB\n");
  if (why == http::error::body_limit)
    return plain_answer(413, "the body is longer than this address takes\n");
  return plain_answer(400, "this is not an HTTP/1.1 request: " + why.message() + "\n");
}

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

// Stream: one of the two above.
template <class Stream>
class BeastConnection final : public HttpConnection,
                              public std::enable_shared_from_this<BeastConnection<Stream>> {
  static constexpr bool kTls = std::is_same_v<Stream, TlsStream>;

 public:
  // tls: of a TlsStream, which keeps it alive.
  BeastConnection(tcp::socket socket, std::shared_ptr<asio::ssl::context> tls, HttpSite& site,
                  BodyBudget& budget, access::FailedHandshakes& failed)
      : ends_{peer_of(socket), local_of(socket), kTls},
        tls_(std::move(tls)),
        stream_(make_stream(std::move(socket))),
        idle_(stream_.get_executor()),
        site_(site),
        budget_(budget),
        failed_(failed) {
    Code ignored;
    tcp_stream().socket().set_option(tcp::no_delay(true), ignored);
    watch_peer(tcp_stream().socket());
  }

  Awaitable<void> serve() override { return serve_requests(); }

  // An answer counts as blocked when it has not left for a second, and a call without an answer for
  // two seconds as a stream without news.
  ConnectionState state() const override {
    const auto age = WallClock::now() - since_;
    const bool waits = (activity_ == Activity::blocked && age < seconds(1)) ||
                       (activity_ == Activity::answering && age > seconds(2));
    return {without_port(ends_.peer), waits ? Activity::waiting : activity_, since_};
  }
  bool closing() const override { return closing_; }
  void end_soon() override {
    ending_ = true;
    if (activity_ == Activity::idle) close();
  }
  void close() override {
    ending_ = closing_ = true;
    if (answering_) answering_->abandon();
    Code ignored;
    tcp_stream().socket().shutdown(tcp::socket::shutdown_both, ignored);
    tcp_stream().close();
    idle_.cancel();
  }

 private:
  Stream make_stream(tcp::socket socket) {
    if constexpr (kTls)
      return Stream(std::move(socket), *tls_);
    else
      return Stream(std::move(socket));
  }
  beast::tcp_stream& tcp_stream() { return beast::get_lowest_layer(stream_); }
  auto token() { return asio::redirect_error(asio::use_awaitable, code_); }

  // GCC 12 lays the frame of this coroutine out wrongly when it is the virtual function itself.
  Awaitable<void> serve_requests() {
    bool goes_on = true;
    if constexpr (kTls) goes_on = co_await shake_hands();
    while (goes_on && !ending_) {
      goes_on = co_await first_byte();
      if (!goes_on) break;
      now(Activity::receiving);
      goes_on = co_await one_request();
      now(Activity::idle);
    }
    close();
  }

  Awaitable<bool> shake_hands() {
    now(Activity::receiving);
    tcp_stream().expires_after(kHandshakeLimit);
    co_await stream_.async_handshake(asio::ssl::stream_base::server, token());
    now(Activity::idle);
    if (!code_) co_return true;
    tell_failure();
    // Somebody typed http:// where the door speaks https://.
    if (ERR_GET_REASON(static_cast<unsigned long>(code_.value())) == SSL_R_HTTP_REQUEST) {
      static constexpr std::string_view kHint =
          "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\n"
          "Connection: close\r\nContent-Length: 46\r\n\r\n"
          "this door speaks TLS: write https:// instead.\n";
      co_await asio::async_write(tcp_stream(), asio::buffer(kHint), token());
    }
    co_return false;
  }

  void tell_failure() {
    if (code_.category() != asio::error::get_ssl_category()) return;  // it only left
    if (const auto line =
            failed_.note(access::source_of(ends_.peer), code_.message(), WallClock::now()))
      spdlog::warn("{}", *line);
  }

  Awaitable<bool> first_byte() {
    if (ahead_) {  // it is being read already
      idle_.expires_after(kIdleLimit);
      co_await idle_.async_wait(token());
      if (ahead_ || gone_) co_return false;
    }
    if (buffer_.size() > 0) co_return true;  // sent ahead
    tcp_stream().expires_after(kIdleLimit);
    const std::size_t bytes = co_await stream_.async_read_some(buffer_.prepare(4096), token());
    buffer_.commit(bytes);
    co_return !code_;
  }

  // True: the connection may be used for another one.
  Awaitable<bool> one_request() {
    Parser parser;
    parser.header_limit(kMaxHeaderBytes);
    parser.body_limit(boost::none);  // it depends on the address
    tcp_stream().expires_after(kHeaderLimit);
    co_await http::async_read_header(stream_, buffer_, parser, token());
    if (code_) co_return co_await refuse(code_);
    HttpRequest request = head_of(parser, ends_);
    const bool is_head = parser.get().method() == http::verb::head;
    const bool is_last = !parser.get().keep_alive();
    auto admitting = site_.admit(request);
    auto admitted = co_await std::move(admitting);
    if (auto* refused = std::get_if<HttpResponse>(&admitted)) {
      if (!parser.is_done() && !is_head) {  // its body is on the way
        auto refusing = refuse_with(std::move(*refused));
        co_return co_await std::move(refusing);
      }
      const bool clean = parser.is_done() && !is_last;  // else the body would be read as a request
      auto refusing = write_plain(std::move(*refused), is_head, clean);
      co_return co_await std::move(refusing);
    }
    const std::size_t limit = std::get<std::size_t>(admitted);
    parser.body_limit(limit);
    if (parser.content_length() && *parser.content_length() > limit)
      co_return co_await refuse(http::make_error_code(http::error::body_limit));
    const std::weak_ptr<BeastConnection> weak = this->weak_from_this();
    BodyBudget::Share share(budget_, without_port(ends_.peer), [weak] {
      if (const auto alive = weak.lock()) alive->close();
    });
    if (!co_await read_body(parser, share)) co_return false;
    share.complete();
    request.body = std::move(parser.get().body());
    now(request.path() == kStopPath ? Activity::stopping : Activity::answering);
    auto answering = site_.answer(std::move(request));
    HttpResponse response = co_await std::move(answering);
    const bool in_pieces = response.stream != nullptr;
    auto writing = in_pieces ? write_stream(std::move(response), !is_last)
                             : write_plain(std::move(response), is_head, !is_last);
    co_return co_await std::move(writing);
  }

  void now(Activity activity) {
    activity_ = activity;
    since_ = WallClock::now();
  }

  Awaitable<bool> read_body(Parser& parser, BodyBudget::Share& share) {
    if (beast::iequals(parser.get()[http::field::expect], "100-continue")) {
      static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
      tcp_stream().expires_after(kWriteLimit);
      co_await asio::async_write(stream_, asio::buffer(kContinue), token());
      if (code_) co_return false;
    }
    const auto until = WallClock::now() + kBodyLimit;
    while (!parser.is_done()) {
      tcp_stream().expires_at(std::min(until, WallClock::now() + kBodyPauseLimit));
      co_await http::async_read_some(stream_, buffer_, parser, token());
      if (code_) co_return co_await refuse(code_);
      now(Activity::receiving);
      if (!share.grow_to(parser.get().body().size(), since_)) co_return co_await refuse_body();
    }
    co_return true;
  }

  // Says why where somebody may still listen. The connection ends.
  Awaitable<bool> refuse(Code why) {
    if (why.category() != http::make_error_code(http::error::bad_method).category() ||
        why == http::error::end_of_stream || why == http::error::partial_message)
      co_return false;
    auto refusing = refuse_with(refusal(why));
    co_return co_await std::move(refusing);
  }

  Awaitable<bool> refuse_body() {
    HttpResponse busy = plain_answer(
        503, "other requests hold the memory that there is for bodies: try again in a moment\n");
    busy.headers.push_back({"Retry-After", "2"});
    auto refusing = refuse_with(std::move(busy));
    co_return co_await std::move(refusing);
  }

  Awaitable<bool> refuse_with(HttpResponse response) {
    auto writing = write_plain(std::move(response), false, false);
    co_await std::move(writing);
    // What the client still sends is read away for a moment: closing on it would cut the answer.
    Code ignored;
    tcp_stream().socket().shutdown(tcp::socket::shutdown_send, ignored);
    tcp_stream().expires_after(seconds(2));
    for (std::size_t left = 1 << 20; left > 0 && !code_;) {
      buffer_.clear();
      const std::size_t bytes = co_await stream_.async_read_some(buffer_.prepare(8192), token());
      left -= std::min(left, bytes);
    }
    co_return false;
  }

  template <class Message>
  void set_head(Message& message, const HttpResponse& response, bool keep) {
    message.result(static_cast<unsigned>(response.status));
    for (const auto& header : response.headers) message.set(header.name, header.value);
    message.keep_alive(keep && !ending_);
  }

  Awaitable<bool> write_plain(HttpResponse response, bool is_head, bool keep) {
    http::response<http::string_body> message{http::status::ok, 11};
    set_head(message, response, keep);
    message.body() = std::move(response.body);
    if (response.status != 304) message.prepare_payload();
    if (is_head) message.body().clear();
    http::response_serializer<http::string_body> serializer(message);
    tcp_stream().expires_after(kWriteLimit);
    if (is_head) {
      co_await http::async_write_header(stream_, serializer, token());
    } else {
      co_await http::async_write(stream_, serializer, token());
    }
    co_return !code_ && message.keep_alive();
  }

  Awaitable<bool> write_stream(HttpResponse response, bool keep) {
    http::response<http::empty_body> message{http::status::ok, 11};
    const bool is_socket = response.status == 101;  // from here on the bytes are its frames
    set_head(message, response, keep);
    if (!is_socket) message.chunked(true);
    http::response_serializer<http::empty_body> serializer(message);
    answering_ = response.stream;
    auto watched = watch_for_close();
    tcp_stream().expires_after(kWriteLimit);
    co_await http::async_write_header(stream_, serializer, token());
    bool done = false;
    bool began = false;  // until its first message a call is at work
    const Activity kind = activity_;
    while (!code_ && !done) {
      tcp_stream().expires_never();
      if (kind != Activity::stopping && began) now(Activity::waiting);
      BodyStream::Piece piece = co_await response.stream->next();
      if (closed_) break;
      done = piece.last;
      tcp_stream().expires_after(kWriteLimit);
      if (kind != Activity::stopping) now(Activity::blocked);
      co_await write_piece(piece, is_socket);
      began = true;
    }
    if (!done) response.stream->abandon();
    answering_.reset();
    if (watched) watched->emit(asio::cancellation_type::total);
    co_return done && !is_socket && !code_ && message.keep_alive();
  }

  Awaitable<void> write_piece(const BodyStream::Piece& piece, bool is_socket) {
    const auto bytes = asio::buffer(piece.bytes);
    if (is_socket) {
      co_await asio::async_write(stream_, bytes, token());
    } else if (piece.last && piece.bytes.empty()) {
      const auto end = http::make_chunk_last();
      co_await asio::async_write(stream_, end, token());
    } else if (piece.last) {
      const auto both = beast::buffers_cat(http::make_chunk(bytes), http::make_chunk_last());
      co_await asio::async_write(stream_, both, token());
    } else {
      const auto chunk = http::make_chunk(bytes);
      co_await asio::async_write(stream_, chunk, token());
    }
  }

  // Reads nothing: what a client sends ahead stays where it is. Emit the signal to end the watch.
  // Behind TLS a close can only be read: that read is the first one of the next request too.
  std::shared_ptr<asio::cancellation_signal> watch_for_close() {
    if constexpr (kTls) {
      if (buffer_.size() == 0 && !ahead_) read_ahead();
      return nullptr;
    } else {
      auto signal = std::make_shared<asio::cancellation_signal>();
      auto self = this->shared_from_this();
      stream_.socket().async_wait(
          tcp::socket::wait_read,
          asio::bind_cancellation_slot(signal->slot(), [self, signal](const Code& code) {
            if (code || !self->answering_) return;
            char one = 0;
            if (::recv(self->stream_.socket().native_handle(), &one, 1, MSG_PEEK | MSG_DONTWAIT) !=
                0)
              return;
            self->client_left();
          }));
      return signal;
    }
  }

  void read_ahead() {
    ahead_ = true;
    tcp_stream().expires_never();
    stream_.async_read_some(buffer_.prepare(4096),
                            [self = this->shared_from_this()](const Code& code, std::size_t bytes) {
                              self->ahead_ = false;
                              self->buffer_.commit(bytes);
                              self->gone_ = static_cast<bool>(code);
                              if (code) self->client_left();
                              self->idle_.cancel();
                            });
  }

  void client_left() {
    if (!answering_) return;
    if (activity_ == Activity::stopping) return;  // it is executed, whoever waits for its answer
    closed_ = true;
    answering_->abandon();
  }

  Ends ends_;
  std::shared_ptr<asio::ssl::context> tls_;
  Stream stream_;
  asio::steady_timer idle_;
  HttpSite& site_;
  beast::flat_buffer buffer_{kMaxHeaderBytes + 8192};
  BodyBudget& budget_;
  access::FailedHandshakes& failed_;
  Code code_;  // of the last operation
  Activity activity_ = Activity::idle;
  DoorInstant since_ = WallClock::now();
  std::shared_ptr<BodyStream> answering_;
  bool ending_ = false, closed_ = false, closing_ = false;
  bool ahead_ = false;  // the next request's first bytes are being read
  bool gone_ = false;   // ... and the client closed instead
};

}  // namespace

std::shared_ptr<HttpConnection> HttpConnection::make(tcp::socket socket,
                                                     std::shared_ptr<asio::ssl::context> tls,
                                                     HttpSite& site, BodyBudget& budget,
                                                     access::FailedHandshakes& failed) {
  if (tls)
    return std::make_shared<BeastConnection<TlsStream>>(std::move(socket), std::move(tls), site,
                                                        budget, failed);
  return std::make_shared<BeastConnection<PlainStream>>(std::move(socket), nullptr, site, budget,
                                                        failed);
}

}  // namespace driftwise::web
