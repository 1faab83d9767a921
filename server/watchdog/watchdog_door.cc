#include "server/watchdog/watchdog_door.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <charconv>
#include <chrono>
#include <list>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include "server/core/ports/spawn.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/notify/notice_json.h"

namespace driftwise::watchdog {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using Code = boost::system::error_code;
constexpr auto kPatience = std::chrono::seconds(10);
constexpr auto kPause = std::chrono::milliseconds(50);
constexpr std::size_t kMostBytes = 64 * 1024;

Result<tcp::endpoint> endpoint_of(const std::string& address) {
  const auto cut = address.rfind(':');
  unsigned port = 65536;
  if (cut != std::string::npos) {
    const char* const last = address.data() + address.size();
    const auto [end, bad] = std::from_chars(address.data() + cut + 1, last, port);
    if (bad != std::errc{} || end != last) port = 65536;
  }
  std::string host = cut == std::string::npos ? "" : address.substr(0, cut);
  if (host.size() > 2 && host.starts_with('[') && host.ends_with(']'))
    host = host.substr(1, host.size() - 2);
  Code code;
  const auto ip = asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, code);
  if (code || port > 65535)
    return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
                "found '" + address + "', expected an address and a port such as 127.0.0.1:9470");
  return tcp::endpoint(ip, static_cast<std::uint16_t>(port));
}

// Takes the same time wherever the first difference is.
bool same_secret(std::string_view found, std::string_view wanted) {
  return found.size() == wanted.size() &&
         CRYPTO_memcmp(found.data(), wanted.data(), wanted.size()) == 0;
}

struct Connection {
  asio::ip::address from;
  std::chrono::steady_clock::time_point since;  // its beginning, then its last sign of life
  bool is_known = false;                        // it has brought one, with the token
  std::function<void()> close = {};
};

struct Shared {  // its connections may outlive the door
  std::string token;
  WatchdogDoor::Take take;
  std::unique_ptr<tls::TlsMaterial> tls;
  std::list<std::shared_ptr<Connection>> connections = {};
};

void make_room(Shared& shared) {
  if (shared.connections.size() < WatchdogDoor::kMaxConnections) return;
  std::map<asio::ip::address, std::ptrdiff_t> unknown;
  for (const auto& one : shared.connections)
    if (!one->is_known) ++unknown[one->from];
  const auto rank = [&](const std::shared_ptr<Connection>& one) {
    return std::tuple(one->is_known, one->is_known ? 0 : -unknown[one->from], one->since);
  };
  const auto first = std::ranges::min_element(shared.connections, {}, rank);
  const auto gone = *first;
  shared.connections.erase(first);
  if (gone->close) gone->close();
}

http::status answer_to(Shared& shared, const http::request<http::string_body>& request,
                       std::string& said) {
  if (request.method() != http::verb::post) {
    said = "a sign of life is a POST\n";
    return http::status::method_not_allowed;
  }
  const auto found = request[http::field::authorization];
  if (!shared.token.empty() &&
      !same_secret({found.data(), found.size()}, "Bearer " + shared.token)) {
    said = "the token is missing or wrong\n";
    return http::status::unauthorized;
  }
  const auto sign = notify::life_sign_from(request.body());
  const Result<void> taken = sign ? shared.take(*sign) : tl::unexpected(sign.error());
  if (taken) return http::status::no_content;
  said = taken.error().message + "\n";
  return taken.error().code == ErrorCode::invalid_argument ? http::status::bad_request
                                                           : http::status::service_unavailable;
}

template <class Stream>
Awaitable<void> talk(std::shared_ptr<Shared> shared, std::shared_ptr<Connection> self,
                     Stream& stream) {
  Code code;
  beast::flat_buffer buffer;
  for (bool goes_on = true; goes_on;) {
    beast::get_lowest_layer(stream).expires_after(kPatience);
    http::request_parser<http::string_body> parser;
    parser.body_limit(kMostBytes);
    parser.header_limit(8 * 1024);
    co_await http::async_read(stream, buffer, parser,
                              asio::redirect_error(asio::use_awaitable, code));
    if (code) co_return;
    http::response<http::string_body> response;
    response.version(11);
    response.result(answer_to(*shared, parser.get(), response.body()));
    if (response.result() == http::status::no_content) {
      self->is_known = true;
      self->since = std::chrono::steady_clock::now();
    }
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    goes_on = parser.get().keep_alive() && response.result() == http::status::no_content;
    response.keep_alive(goes_on);
    response.prepare_payload();
    beast::get_lowest_layer(stream).expires_after(kPatience);
    co_await http::async_write(stream, response, asio::redirect_error(asio::use_awaitable, code));
    if (code) co_return;
  }
}

Awaitable<void> serve_one(std::shared_ptr<Shared> shared, std::shared_ptr<Connection> self,
                          tcp::socket socket) {
  Code code;
  const auto close_at_need = [&self](beast::tcp_stream& stream) {
    self->close = [&stream] { stream.close(); };
  };
  if (shared->tls == nullptr) {
    beast::tcp_stream stream(std::move(socket));
    close_at_need(stream);
    auto talking = talk(shared, self, stream);
    co_await std::move(talking);
    self->close = nullptr;
  } else {
    const auto context = shared->tls->context();
    beast::ssl_stream<beast::tcp_stream> stream(std::move(socket), *context);
    close_at_need(beast::get_lowest_layer(stream));
    beast::get_lowest_layer(stream).expires_after(kPatience);
    co_await stream.async_handshake(asio::ssl::stream_base::server,
                                    asio::redirect_error(asio::use_awaitable, code));
    if (!code) {
      auto talking = talk(shared, self, stream);
      co_await std::move(talking);
    }
    self->close = nullptr;
  }
  shared->connections.remove(self);
}

class ListeningDoor final : public WatchdogDoor {
 public:
  ListeningDoor(const asio::any_io_executor& executor, std::shared_ptr<Shared> shared)
      : acceptor_(executor), shared_(std::move(shared)) {}

  Code listen(const tcp::endpoint& endpoint) {
    Code code;
    acceptor_.open(endpoint.protocol(), code);
    if (!code) acceptor_.set_option(tcp::acceptor::reuse_address(true), code);
    if (!code) acceptor_.bind(endpoint, code);
    if (!code) acceptor_.listen(asio::socket_base::max_listen_connections, code);
    if (!code) spawn(acceptor_.get_executor(), accept_all());
    return code;
  }

  std::string address() const override {
    Code gone;
    const auto end = acceptor_.local_endpoint(gone);
    const std::string host = end.address().to_string();
    return (end.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(end.port());
  }

 private:
  Awaitable<void> accept_all() {
    while (acceptor_.is_open()) {
      Code code;
      tcp::socket socket =
          co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, code));
      if (code == asio::error::operation_aborted) co_return;
      if (code) {  // out of descriptors, for one: it would fail again at once
        asio::steady_timer pause(acceptor_.get_executor(), kPause);
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, code));
        continue;
      }
      const auto peer = socket.remote_endpoint(code);
      if (code) continue;  // it left again
      make_room(*shared_);
      const auto connection = std::make_shared<Connection>(
          Connection{peer.address(), std::chrono::steady_clock::now()});
      shared_->connections.push_back(connection);
      spawn(acceptor_.get_executor(), serve_one(shared_, connection, std::move(socket)));
    }
  }

  tcp::acceptor acceptor_;
  std::shared_ptr<Shared> shared_;
};

}  // namespace

Result<std::unique_ptr<WatchdogDoor>> WatchdogDoor::open(asio::any_io_executor executor,
                                                         DoorOptions options, Take take) {
  DRIFTWISE_TRY(const auto endpoint, endpoint_of(options.listen));
  if (!endpoint.address().is_loopback() && (options.token.empty() || options.tls == nullptr))
    return fail(ErrorCode::invalid_argument, reasons::kNeedsTls,
                "'" + options.listen + "' can be reached from outside this computer, and " +
                    (options.token.empty() ? "there is no token: name a file of one with "
                                             "--secret"
                                           : "its token would cross the network readable: name "
                                             "--certificate and --key, 'driftwise cert init' makes "
                                             "them") +
                    ", or listen on 127.0.0.1");
  auto shared = std::make_shared<Shared>();
  shared->token = std::move(options.token);
  shared->take = std::move(take);
  shared->tls = std::move(options.tls);
  auto door = std::make_unique<ListeningDoor>(executor, std::move(shared));
  if (const Code code = door->listen(endpoint))
    return fail(ErrorCode::unavailable, reasons::kCannotListen,
                "'" + options.listen + "': " + code.message() + "; choose another port");
  return door;
}

}  // namespace driftwise::watchdog
