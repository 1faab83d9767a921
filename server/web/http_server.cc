#include "server/web/http_server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <charconv>
#include <exception>
#include <list>
#include <optional>
#include <thread>
#include <vector>

#include "server/access/door_address.h"
#include "server/access/peer_name.h"
#include "server/core/ports/spawn.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/web/http_connection.h"

namespace driftwise::web {
namespace {

using asio::ip::tcp;
using Connections = std::list<std::shared_ptr<HttpConnection>>;
constexpr std::size_t kMostClosing = 64;  // that were told to close and are on their way out
constexpr auto kGrace =
    std::chrono::milliseconds(500);  // for answers under way when the daemon ends

Result<tcp::endpoint> parse(const std::string& address, bool secure) {
  const std::size_t cut = address.rfind(':');
  boost::system::error_code code;
  unsigned port = 65536;
  if (cut != std::string::npos)
    std::from_chars(address.data() + cut + 1, address.data() + address.size(), port);
  const std::string host = cut == std::string::npos ? "" : address.substr(0, cut);
  const bool bracketed = host.size() > 2 && host.starts_with('[') && host.ends_with(']');
  const auto ip = asio::ip::make_address(host == "localhost" ? "127.0.0.1"
                                         : bracketed         ? host.substr(1, host.size() - 2)
                                                             : host,
                                         code);
  if (code || port > 65535)
    return fail(
        ErrorCode::invalid_argument, reasons::kBadAddress,
        "http address '" + address + "': expected an address and a port such as 127.0.0.1:8080");
  if (!secure && !ip.is_loopback())
    return fail(ErrorCode::invalid_argument, reasons::kNeedsTls,
                "http address '" + address +
                    "' can be reached from outside this computer, and this door has no TLS: for "
                    "others give [access] http, with certificate and key of 'driftwise cert init'; "
                    "here listen on 127.0.0.1");
  return tcp::endpoint(ip, static_cast<std::uint16_t>(port));
}

class ThreadedHttpServer final : public HttpServer {
 public:
  explicit ThreadedHttpServer(std::unique_ptr<tls::TlsMaterial> tls)
      : tls_(std::move(tls)), acceptor_(context_), grace_(context_) {}
  ~ThreadedHttpServer() override {
    asio::post(context_, [this] { end(); });
    work_.reset();
    if (!thread_.joinable()) thread_ = std::thread([this] { context_.run(); });
    thread_.join();  // the context runs out of work when every call and connection is over
  }

  boost::system::error_code listen(const tcp::endpoint& endpoint) {
    boost::system::error_code code;
    acceptor_.open(endpoint.protocol(), code);
    if (!code) acceptor_.set_option(tcp::acceptor::reuse_address(true), code);
    if (!code)
      code.assign(access::bind_door(acceptor_.native_handle(), endpoint.data(),
                                    static_cast<unsigned>(endpoint.size())),
                  boost::system::system_category());
    if (!code) acceptor_.listen(asio::socket_base::max_listen_connections, code);
    if (!code) endpoint_ = acceptor_.local_endpoint(code);
    return code;
  }

  std::uint16_t port() const override { return endpoint_.port(); }
  std::string address() const override {
    const std::string host = endpoint_.address().to_string();
    return (endpoint_.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(port());
  }
  std::string origin() const override { return (tls_ ? "https://" : "http://") + address(); }
  asio::any_io_executor executor() const override {
    return const_cast<asio::io_context&>(context_).get_executor();
  }

  void serve(std::unique_ptr<HttpSite> site) override {
    site_ = std::move(site);
    spawn(context_.get_executor(), accept_all());
    thread_ = std::thread([this] { context_.run(); });
  }

 private:
  Awaitable<void> accept_all() {
    while (acceptor_.is_open()) {
      boost::system::error_code code;
      tcp::socket socket =
          co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, code));
      if (code == asio::error::operation_aborted) co_return;
      if (code) {  // out of descriptors, or a client that left again
        asio::steady_timer pause(context_, std::chrono::milliseconds(50));
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, code));
      } else if (make_room(socket)) {
        take(std::move(socket));
      }
    }
  }

  void take(tcp::socket socket) {
    const auto place = connections_.insert(
        connections_.end(),
        HttpConnection::make(std::move(socket), tls_ ? tls_->context() : nullptr, *site_, budget_,
                             failed_));
    asio::co_spawn(context_, (*place)->serve(), [this, place](const std::exception_ptr& bug) {
      connections_.erase(place);
      if (connections_.empty()) grace_.cancel();
      try {
        if (bug) std::rethrow_exception(bug);
      } catch (const std::exception& what) {
        spdlog::error("a web connection ended with an exception: {}", what.what());
      }
    });
  }

  bool make_room(const tcp::socket& socket) {
    boost::system::error_code gone;
    const auto end = socket.remote_endpoint(gone);
    if (gone) return false;
    std::vector<ConnectionState> present;
    std::vector<HttpConnection*> places;
    for (const auto& one : connections_) {
      if (one->closing()) continue;
      present.push_back(one->state());
      places.push_back(one.get());
    }
    const auto slowest = makes_room(present, access::host_name_of(*end.data()), {});
    if (slowest && *slowest >= places.size()) return false;
    if (slowest) places[*slowest]->close();
    return connections_.size() < kMaxConnections + kMostClosing;
  }

  void end() {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    for_each_connection(&HttpConnection::end_soon);
    if (connections_.empty()) return;
    grace_.expires_after(kGrace);
    grace_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) for_each_connection(&HttpConnection::close);
    });
  }

  void for_each_connection(void (HttpConnection::*what)()) {
    const Connections present = connections_;  // one may end, and leave the list, meanwhile
    for (const auto& one : present) ((*one).*what)();
  }

  std::unique_ptr<tls::TlsMaterial> tls_;
  asio::io_context context_{1};
  std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_{
      context_.get_executor()};
  tcp::acceptor acceptor_;
  tcp::endpoint endpoint_;
  asio::steady_timer grace_;
  std::unique_ptr<HttpSite> site_;
  BodyBudget budget_;  // the connections hold shares of it
  access::FailedHandshakes failed_{"page"};
  Connections connections_;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<HttpServer>> HttpServer::open(const std::string& address,
                                                     std::unique_ptr<tls::TlsMaterial> tls) {
  DRIFTWISE_TRY(const auto endpoint, parse(address, tls != nullptr));
  const bool tls_door = tls != nullptr;
  auto server = std::make_unique<ThreadedHttpServer>(std::move(tls));
  if (const auto code = server->listen(endpoint))
    return fail(ErrorCode::unavailable, reasons::kCannotListen,
                "http address '" + address + "': " + code.message() +
                    "; choose another port in http of " + (tls_door ? "[access]" : "[cell]"));
  return server;
}

}  // namespace driftwise::web
