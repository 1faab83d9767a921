#include "tests/support/scripted_peer.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include "server/core/ports/spawn.h"

namespace driftwise::tests {
namespace {

using asio::ip::tcp;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

}  // namespace

ScriptedPeer::ScriptedPeer(asio::io_context& context) : context_(context), acceptor_(context) {
  listen_again();
}

ScriptedPeer::~ScriptedPeer() = default;

void ScriptedPeer::listen_again() {
  const tcp::endpoint here(asio::ip::address_v4::loopback(), port_);
  acceptor_.open(here.protocol());
  acceptor_.set_option(tcp::acceptor::reuse_address(true));
  acceptor_.bind(here);
  acceptor_.listen();
  port_ = acceptor_.local_endpoint().port();
  spawn(context_.get_executor(), accept());
}

void ScriptedPeer::stop_listening() { acceptor_.close(); }

Awaitable<void> ScriptedPeer::accept() {
  for (;;) {
    auto [error, socket] = co_await acceptor_.async_accept(kAsTuple);
    if (error) co_return;
    ++connections_;
    Script script;
    if (!scripts_.empty()) {
      script = std::move(scripts_.front());
      scripts_.pop_front();
    }
    socket.set_option(tcp::no_delay(true));
    ++running_;
    spawn(context_.get_executor(), play(std::move(socket), std::move(script)));
  }
}

Awaitable<void> ScriptedPeer::play(tcp::socket socket, Script script) {
  for (const auto& step : script) {
    if (step.kind == Step::Kind::close) break;
    if (step.kind == Step::Kind::send) {
      // A pause between segments, so that the client sees them one by one.
      asio::steady_timer pause(context_, std::chrono::milliseconds(2));
      (void)co_await pause.async_wait(kAsTuple);
      (void)co_await asio::async_write(socket, asio::buffer(step.bytes), kAsTuple);
      ++sent_;
      continue;
    }
    std::string got(step.bytes.size(), '\0');
    const auto [error, count] = co_await asio::async_read(socket, asio::buffer(got), kAsTuple);
    got.resize(count);
    if (got != step.bytes) {
      problems_.push_back("expected '" + step.bytes + "', got '" + got + "' " +
                          (error ? error.message() : ""));
      --running_;
      co_return;
    }
  }
  --running_;
  if (!script.empty() && script.back().kind == Step::Kind::close) co_return;
  char more[256];
  for (;;) {
    const auto [error, count] = co_await socket.async_read_some(asio::buffer(more), kAsTuple);
    if (error) co_return;
    problems_.push_back("not in the script: '" + std::string(more, count) + "'");
  }
}

}  // namespace driftwise::tests
