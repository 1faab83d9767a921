#include "server/line/line_listener.h"

#include <net/if.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "server/access/door_address.h"
#include "server/line/line_address.h"

namespace driftwise::line {

namespace {

constexpr auto kLookEvery = std::chrono::seconds(2);

}  // namespace

LineListener::LineListener(boost::asio::any_io_executor executor, Tcp::endpoint where,
                           std::string interface)
    : acceptor_(executor),
      pause_(executor),
      look_(executor),
      where_(std::move(where)),
      interface_(std::move(interface)) {}

LineListener::Code LineListener::open() {
  const Code error = listen();
  if (interface_.empty() || ::if_nametoindex(interface_.c_str()) != 0) return error;
  spdlog::warn("text line {}: this computer has no network interface '{}' now; it is waited for",
               text_of(where_), interface_);
  return {};
}

LineListener::Code LineListener::listen() {
  // Before the socket is bound to it: an interface that is replaced meanwhile is seen next time.
  const unsigned index = interface_.empty() ? 1 : ::if_nametoindex(interface_.c_str());
  if (index == 0) return Code(ENODEV, boost::system::system_category());
  Code error, ignored;
  acceptor_.close(ignored);
  index_ = 0;
  ++opened_;
  const auto attempt = [&](auto&& step) {
    if (!error) step();
  };
  attempt([&] { acceptor_.open(where_.protocol(), error); });
  attempt([&] { acceptor_.set_option(Tcp::acceptor::reuse_address(true), error); });
  attempt([&] {
    if (interface_.empty()) return;
    // Connections by another network are not even answered by the kernel.
    if (::setsockopt(acceptor_.native_handle(), SOL_SOCKET, SO_BINDTODEVICE, interface_.data(),
                     static_cast<socklen_t>(interface_.size())) != 0)
      error.assign(errno, boost::system::system_category());
  });
  attempt([&] {
    error.assign(access::bind_door(acceptor_.native_handle(), where_.data(),
                                   static_cast<unsigned>(where_.size())),
                 boost::system::system_category());
  });
  attempt([&] { acceptor_.listen(boost::asio::socket_base::max_listen_connections, error); });
  if (error) {
    acceptor_.close(ignored);
    return error;
  }
  index_ = index;
  where_ = acceptor_.local_endpoint(ignored);
  return {};
}

void LineListener::begin(std::function<void(Tcp::socket)> take) {
  take_ = std::move(take);
  if (index_ != 0) accept_next();
  if (!interface_.empty()) look_at_interface();
}

void LineListener::shut() {
  shut_ = true;
  Code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
  look_.cancel();
  take_ = nullptr;
}

void LineListener::accept_next() {
  acceptor_.async_accept(
      [self = shared_from_this(), opened = opened_](Code error, Tcp::socket socket) {
        if (self->shut_ || opened != self->opened_) return;
        if (!error) {
          self->take_(std::move(socket));
          if (!self->shut_) self->accept_next();
          return;
        }
        // Out of descriptors, for one: a new attempt at once would fail at once, again and again.
        self->pause_.expires_after(std::chrono::milliseconds(100));
        self->pause_.async_wait([self, opened](Code stopped) {
          if (!stopped && !self->shut_ && opened == self->opened_) self->accept_next();
        });
      });
}

void LineListener::look_at_interface() {
  look_.expires_after(kLookEvery);
  look_.async_wait([self = shared_from_this()](Code stopped) {
    if (stopped || self->shut_) return;
    const unsigned present = ::if_nametoindex(self->interface_.c_str());
    if (present != 0 && present != self->index_) {
      const auto error = self->listen();
      if (!error) {
        spdlog::info("text line {}: listens on the network interface '{}' now",
                     text_of(self->where_), self->interface_);
        self->accept_next();
      } else if (!std::exchange(self->told_, true)) {
        spdlog::error("text line {}: cannot listen on the network interface '{}': {}",
                      text_of(self->where_), self->interface_, error.message());
      }
      if (!error) self->told_ = false;
    }
    self->look_at_interface();
  });
}

}  // namespace driftwise::line
