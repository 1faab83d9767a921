#pragma once
// The other end of a line, word by word: a TCP server on a free loopback port that expects certain
// bytes and answers with certain bytes. Runs on the test's own io_context.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "server/core/ports/awaitable.h"

namespace driftwise::tests {

struct Step {
  enum class Kind { expect, send, close } kind;
  std::string bytes;
};
inline Step expect(std::string bytes) { return {Step::Kind::expect, std::move(bytes)}; }
// One segment each: a reply given in several of them arrives in pieces.
inline Step send(std::string bytes) { return {Step::Kind::send, std::move(bytes)}; }
inline Step hang_up() { return {Step::Kind::close, {}}; }
using Script = std::vector<Step>;

class ScriptedPeer {
 public:
  explicit ScriptedPeer(asio::io_context& context);
  ~ScriptedPeer();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // The next connection follows this script, then stays open and silent until the client goes.
  void on_connection(Script script) { scripts_.push_back(std::move(script)); }
  void stop_listening();  // connections are refused from now on
  void listen_again();    // on the same port
  int connections() const { return connections_; }
  int sent() const { return sent_; }  // segments that are on their way, of all connections
  const std::vector<std::string>& problems() const {
    return problems_;
  }  // what came instead of the expected bytes
  bool finished() const { return scripts_.empty() && running_ == 0; }  // every step was played

 private:
  Awaitable<void> accept();
  Awaitable<void> play(asio::ip::tcp::socket socket, Script script);

  asio::io_context& context_;
  asio::ip::tcp::acceptor acceptor_;
  std::uint16_t port_ = 0;
  std::deque<Script> scripts_;
  std::vector<std::string> problems_;
  int connections_ = 0, running_ = 0, sent_ = 0;
};

}  // namespace driftwise::tests
