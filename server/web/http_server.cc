#include "server/web/http_server.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <list>

#include "server/web/metrics.h"

namespace driftwise::web {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr auto kIdleLimit = std::chrono::seconds(30);
constexpr std::size_t kMaxHeaderBytes = 8192, kMaxBodyBytes = 1024;  // nothing here takes a body

using Response = http::response<http::string_body>;

Response answer(const http::request<http::string_body>& request, const application::Cell& cell) {
  Response response{http::status::ok, request.version()};
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.keep_alive(request.keep_alive());
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.set(http::field::allow, "GET, HEAD");
    response.body() = "only GET and HEAD are answered here\n";
  } else if (request.target() == "/healthz") {
    response.body() = "ok\n";
  } else if (request.target() == "/metrics") {
    response.body() = metrics_text(cell.status());
  } else {
    response.result(http::status::not_found);
    response.body() = "nothing here; there are /healthz and /metrics\n";
  }
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

// owner: alive as long as the server is; a connection that outlives it ends at its next request.
Awaitable<void> serve(tcp::socket socket, const application::Cell& cell,
                      std::weak_ptr<void> owner) {
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer(kMaxHeaderBytes + kMaxBodyBytes);
  while (true) {
    boost::system::error_code code;
    http::request_parser<http::string_body> parser;
    parser.header_limit(kMaxHeaderBytes);
    parser.body_limit(kMaxBodyBytes);
    stream.expires_after(kIdleLimit);
    co_await http::async_read(stream, buffer, parser,
                              asio::redirect_error(asio::use_awaitable, code));
    if (code || owner.expired()) co_return;
    Response response = answer(parser.get(), cell);
    co_await http::async_write(stream, response, asio::redirect_error(asio::use_awaitable, code));
    if (code || !response.keep_alive()) co_return;
  }
}

Awaitable<void> accept_all(tcp::acceptor& acceptor, const application::Cell& cell,
                           std::weak_ptr<void> owner) {
  while (!owner.expired()) {
    boost::system::error_code code;
    tcp::socket socket =
        co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, code));
    if (code == asio::error::operation_aborted || owner.expired()) co_return;
    if (code) continue;
    asio::co_spawn(socket.get_executor(), serve(std::move(socket), cell, owner), asio::detached);
  }
}

class BeastHttpServer final : public HttpServer {
 public:
  BeastHttpServer(tcp::acceptor acceptor, const application::Cell& cell)
      : acceptor_(std::move(acceptor)) {
    asio::co_spawn(acceptor_.get_executor(), accept_all(acceptor_, cell, alive_), asio::detached);
  }
  std::uint16_t port() const override { return acceptor_.local_endpoint().port(); }

 private:
  tcp::acceptor acceptor_;
  std::shared_ptr<int> alive_ = std::make_shared<int>();
};

Result<tcp::endpoint> parse_loopback(const std::string& address) {
  const std::size_t cut = address.rfind(':');
  boost::system::error_code code;
  unsigned port = 65536;
  if (cut != std::string::npos)
    std::from_chars(address.data() + cut + 1, address.data() + address.size(), port);
  const std::string host = cut == std::string::npos ? "" : address.substr(0, cut);
  const auto ip = asio::ip::make_address(host == "localhost" ? "127.0.0.1"
                                         : host == "[::1]"   ? "::1"
                                                             : host,
                                         code);
  if (code || port > 65535 || !ip.is_loopback())
    return fail(ErrorCode::invalid_argument, "BAD_ADDRESS",
                "http address '" + address +
                    "': expected a loopback address and port such as 127.0.0.1:8080");
  return tcp::endpoint(ip, static_cast<std::uint16_t>(port));
}

}  // namespace

Result<std::unique_ptr<HttpServer>> HttpServer::open(asio::any_io_executor executor,
                                                     const std::string& address,
                                                     const application::Cell& cell) {
  const auto endpoint = parse_loopback(address);
  if (!endpoint) return tl::unexpected(endpoint.error());
  tcp::acceptor acceptor(executor);
  boost::system::error_code code;
  acceptor.open(endpoint->protocol(), code);
  if (!code) acceptor.set_option(tcp::acceptor::reuse_address(true), code);
  if (!code) acceptor.bind(*endpoint, code);
  if (!code) acceptor.listen(asio::socket_base::max_listen_connections, code);
  if (code)
    return fail(ErrorCode::unavailable, "CANNOT_LISTEN",
                "http address '" + address + "': " + code.message() +
                    "; choose another port in [cell] http");
  return std::make_unique<BeastHttpServer>(std::move(acceptor), cell);
}

}  // namespace driftwise::web
