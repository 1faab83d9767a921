#pragma once
// The socket that listens for text lines. One that belongs to a network interface waits until the
// interface is there, and follows it when it comes back as a new one (a USB adapter that is pulled
// and plugged): the kernel binds a socket to an interface's index, not to its name.
//
// Executor's thread. Handlers keep it alive; after shut() nothing is handed over.

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>

namespace driftwise::line {

class LineListener : public std::enable_shared_from_this<LineListener> {
 public:
  using Tcp = boost::asio::ip::tcp;
  using Code = boost::system::error_code;
  // interface: empty: none.
  LineListener(boost::asio::any_io_executor executor, Tcp::endpoint where, std::string interface);

  // Listens, where the interface is there. A named interface that is not: no error, it is waited
  // for.
  Code open();
  // Once, after open().
  void begin(std::function<void(Tcp::socket)> take);
  void shut();
  bool is_shut() const { return shut_; }
  const Tcp::endpoint& endpoint() const { return where_; }  // with the real port

 private:
  Code listen();
  void accept_next();
  void look_at_interface();

  Tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_, look_;
  Tcp::endpoint where_;
  std::string interface_;
  unsigned index_ = 0;  // of the interface that the socket is bound to; 0: it does not listen
  unsigned opened_ = 0;
  bool told_ = false, shut_ = false;
  std::function<void(Tcp::socket)> take_;
};

}  // namespace driftwise::line
