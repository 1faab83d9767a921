#include "server/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace driftwise {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

void notify_manager(const std::string& socket_path, std::string_view state) {
  sockaddr_un address{};
  if (socket_path.empty() || socket_path.size() >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, socket_path.data(), socket_path.size());
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // the abstract name space
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_path.size());
  // Nobody to tell when it fails: the manager notices by itself.
  static_cast<void>(sendto(fd, state.data(), state.size(), MSG_NOSIGNAL,
                           reinterpret_cast<const sockaddr*>(&address), length));
  close(fd);
}

}  // namespace

void tell_service_manager_of_wait(const std::string& why) {
  notify_manager(environment("NOTIFY_SOCKET"), "STATUS=" + why.substr(0, why.find('\n')));
}

// Alive as long as its timer's handler is queued; ends when the manager forgets it.
struct ServiceManager::Watchdog : std::enable_shared_from_this<Watchdog> {
  Watchdog(boost::asio::any_io_executor executor, std::string socket_path,
           std::chrono::microseconds half_period)
      : timer(std::move(executor)), path(std::move(socket_path)), every(half_period) {}

  void tell() {
    if (ended) return;
    notify_manager(path, "WATCHDOG=1");
    timer.expires_after(every);
    timer.async_wait([self = shared_from_this()](boost::system::error_code cancelled) {
      if (!cancelled) self->tell();
    });
  }

  boost::asio::steady_timer timer;
  std::string path;
  std::chrono::microseconds every;
  bool ended = false;  // executor's thread
};

ServiceManager::ServiceManager(boost::asio::any_io_executor executor)
    : socket_(environment("NOTIFY_SOCKET")) {
  notify_manager(socket_, "READY=1\nSTATUS=");
  const long long period_us = std::atoll(environment("WATCHDOG_USEC").c_str());
  if (socket_.empty() || period_us <= 0) return;
  watchdog_ =
      std::make_shared<Watchdog>(executor, socket_, std::chrono::microseconds(period_us / 2));
  boost::asio::post(executor, [watchdog = watchdog_] { watchdog->tell(); });
}

ServiceManager::~ServiceManager() {
  notify_manager(socket_, "STOPPING=1");
  if (!watchdog_) return;
  const auto executor = watchdog_->timer.get_executor();
  boost::asio::post(executor, [watchdog = std::move(watchdog_)] {
    watchdog->ended = true;
    watchdog->timer.cancel();
  });
}

}  // namespace driftwise
