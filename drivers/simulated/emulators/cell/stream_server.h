#pragma once
// The sockets of one emulated device: a TCP listener with its connections, and optionally a serial
// line (a pseudo- terminal). Knows bytes only. One thread; everything runs on the io_context that
// is handed in, which must stop before this is destroyed.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/wire.h"

namespace driftwise::simulated {

class StreamServer {
 public:
  struct Handler {
    std::function<void(Session, Link)> opened;
    std::function<void(Session)> closed;
    std::function<void(Session, std::string_view)> received;
  };

  StreamServer(boost::asio::io_context& io, Handler handler, WireOptions wire, std::uint64_t salt);
  ~StreamServer();

  // address: "127.0.0.1:50000", port 0 for a free one; loopback only. Gives the address in use.
  // Throws SetupError.
  std::string listen(const std::string& address, int max_clients);
  // Opens a pseudo-terminal as session 0 and gives its path. Throws SetupError.
  std::string open_serial();

  void send(Session session, std::string bytes);
  void drop_all();  // TCP connections; the serial line stays
  void refuse_until(std::chrono::steady_clock::time_point until) { refuse_until_ = until; }

 private:
  class Connection;
  class TcpConnection;
  class SerialConnection;
  void accept();
  void adopt(std::shared_ptr<Connection> connection, Link link);
  void forget(Session session);

  boost::asio::io_context& io_;
  Handler handler_;
  WireOptions wire_;
  std::uint64_t salt_;
  std::unique_ptr<boost::asio::ip::tcp::acceptor> acceptor_;
  std::map<Session, std::shared_ptr<Connection>> connections_;
  int max_clients_ = 1;
  Session last_session_ = 0;
  std::chrono::steady_clock::time_point refuse_until_{};
};

}  // namespace driftwise::simulated
