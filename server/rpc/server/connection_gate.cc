#include "server/rpc/server/connection_gate.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <list>
#include <map>
#include <thread>
#include <tuple>
#include <utility>

#include "server/access/door_address.h"
#include "server/access/peer_name.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::rpc {
namespace {

// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

struct SocketAddress {
  sockaddr_storage bytes{};
  socklen_t size = 0;
};

constexpr std::string_view kUnix = "unix:";

Result<SocketAddress> unix_address_from(std::string_view path) {
  SocketAddress out;
  auto& address = reinterpret_cast<sockaddr_un&>(out.bytes);
  if (path.empty() || path.size() >= sizeof address.sun_path)
    return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
                "socket " + std::string(path) + ": found a path of " + std::to_string(path.size()) +
                    " bytes, expected at most " + std::to_string(sizeof address.sun_path - 1));
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  out.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + 1);
  return out;
}

Result<SocketAddress> socket_address_from(const std::string& text) {
  if (text.starts_with(kUnix)) return unix_address_from(std::string_view(text).substr(5));
  const auto colon = text.rfind(':');
  std::string host = text.substr(0, colon);
  unsigned port = 65'536;
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [after, code] = std::from_chars(text.data() + colon + 1, end, port);
    if (code != std::errc{} || after != end) port = 65'536;
  }
  if (host == "localhost") host = "127.0.0.1";
  SocketAddress out;
  auto& v4 = reinterpret_cast<sockaddr_in&>(out.bytes);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(out.bytes);
  if (port <= 65'535 && ::inet_pton(AF_INET, host.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(static_cast<std::uint16_t>(port));
    out.size = sizeof v4;
    return out;
  }
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (port <= 65'535 && ::inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(static_cast<std::uint16_t>(port));
    out.size = sizeof v6;
    return out;
  }
  return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
              "listen: found '" + text + "', expected host:port, for example 127.0.0.1:50051");
}

// Of another start that was killed. A file of another kind is left alone, and bind() refuses.
void remove_old_socket(const sockaddr_storage& address) {
  if (address.ss_family != AF_UNIX) return;
  const char* path = reinterpret_cast<const sockaddr_un&>(address).sun_path;
  struct stat about {};
  if (::lstat(path, &about) == 0 && S_ISSOCK(about.st_mode)) ::unlink(path);
}

// Nobody can connect between bind() and listen(), so the mode is in force for the first one.
bool keep_to_owner(const sockaddr_storage& address) {
  if (address.ss_family != AF_UNIX) return true;
  return ::chmod(reinterpret_cast<const sockaddr_un&>(address).sun_path, 0600) == 0;
}

bool is_ours(int socket, const sockaddr_storage& from) {
  if (from.ss_family != AF_UNIX) return true;
  ucred who{};
  socklen_t size = sizeof who;
  return ::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 &&
         (who.uid == ::geteuid() || who.uid == 0);
}

std::uint16_t port_of(const sockaddr_storage& address) {
  if (address.ss_family == AF_UNIX) return 0;
  return ntohs(address.ss_family == AF_INET
                   ? reinterpret_cast<const sockaddr_in&>(address).sin_port
                   : reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
}

ino_t inode_of(int fd) {
  struct stat about {};
  return ::fstat(fd, &about) == 0 ? about.st_ino : 0;
}

// Milliseconds without a byte in either direction.
std::uint32_t silent_ms(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
  return std::min(info.tcpi_last_data_recv, info.tcpi_last_data_sent);
}

}  // namespace

class ConnectionGate::Listener {
 public:
  Listener(Descriptor socket, SocketAddress where, std::shared_ptr<const CallBook> calls,
           Quotas quotas)
      : socket_(std::move(socket)),
        wake_(::eventfd(0, EFD_CLOEXEC)),
        where_(where),
        calls_(std::move(calls)),
        quotas_(quotas) {}
  ~Listener() {
    const std::uint64_t one = 1;
    static_cast<void>(!::write(wake_.get(), &one, sizeof one));
    if (thread_.joinable()) thread_.join();
    remove_old_socket(where_.bytes);
  }

  std::uint16_t port() const { return port_of(where_.bytes); }
  void accept_for(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> server,
                  void (*came)(const std::string&)) {
    server_ = std::move(server);
    came_ = came;
    thread_ = std::thread([this] { accept_all(); });
  }

 private:
  // gRPC owns the descriptor, and closes it when it likes: the number alone says nothing, the
  // socket's inode tells whether it is still this one.
  struct Connection {
    int fd;
    ino_t inode;
    std::string host, peer;
  };

  void accept_all() {
    std::array<pollfd, 2> waited{{{socket_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
    for (;;) {
      if (::poll(waited.data(), waited.size(), -1) < 0 && errno != EINTR) return;
      if (waited[1].revents != 0) return;
      if (waited[0].revents == 0) continue;
      sockaddr_storage from{};
      from.ss_family = where_.bytes.ss_family;  // a unix client without a name tells none
      socklen_t size = sizeof from;
      Descriptor fresh(::accept4(socket_.get(), reinterpret_cast<sockaddr*>(&from), &size,
                                 SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (fresh.get() >= 0)
        take(std::move(fresh), from);
      else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS)
        pause_without_descriptors();
    }
  }

  // Somebody else holds them: the oldest idle one of ours goes, and the next attempt is not at
  // once.
  void pause_without_descriptors() {
    forget_closed();
    close_slowest(nullptr);
    pollfd waited{wake_.get(), POLLIN, 0};
    ::poll(&waited, 1, 50);
  }

  void take(Descriptor fresh, const sockaddr_storage& from) {
    const int on = 1;
    ::setsockopt(fresh.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (!is_ours(fresh.get(), from)) return;
    const auto& address = reinterpret_cast<const sockaddr&>(from);
    const std::string host = access::host_name_of(address);
    forget_closed();
    std::map<std::string, std::size_t> counts;
    for (const auto& one : connections_) ++counts[one.host];
    if (counts[host] >= quotas_.per_peer) {
      close_slowest(&host);
    } else if (connections_.size() >= quotas_.in_all) {
      const auto busiest = std::max_element(counts.begin(), counts.end(),
                                            [](auto& a, auto& b) { return a.second < b.second; });
      close_slowest(&busiest->first);
    }
    connections_.push_back(
        {fresh.get(), inode_of(fresh.get()), host, access::peer_name_of(address)});
    if (came_) came_(host);
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters handed;
    handed.listener_fd = socket_.get();
    handed.fd = fresh.release();
    server_->HandleNewConnection(&handed);
  }

  void forget_closed() {
    std::erase_if(connections_,
                  [](const Connection& one) { return inode_of(one.fd) != one.inode; });
  }

  // Of one host, or of all. Shut down through a descriptor of our own: the number may be another
  // socket's by then, and is looked at again.
  void close_slowest(const std::string* host) {
    auto slowest = connections_.end();
    std::tuple<bool, std::uint32_t> best;
    for (auto one = connections_.begin(); one != connections_.end(); ++one) {
      if (host && one->host != *host) continue;
      const std::tuple rank(calls_->known_calls(one->peer) == 0, silent_ms(one->fd));
      if (slowest != connections_.end() && rank <= best) continue;
      slowest = one;
      best = rank;
    }
    if (slowest == connections_.end()) return;
    const Descriptor own(::fcntl(slowest->fd, F_DUPFD_CLOEXEC, 0));
    if (own.get() >= 0 && inode_of(own.get()) == slowest->inode) ::shutdown(own.get(), SHUT_RDWR);
    spdlog::debug("the gRPC connection of {} makes room for another one", slowest->peer);
    connections_.erase(slowest);
  }

  Descriptor socket_, wake_;
  SocketAddress where_;
  std::shared_ptr<const CallBook> calls_;
  Quotas quotas_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> server_;
  void (*came_)(const std::string&) = nullptr;
  std::list<Connection> connections_;
  std::thread thread_;
};

Result<std::unique_ptr<ConnectionGate>> ConnectionGate::open(
    const std::string& address, std::shared_ptr<const CallBook> calls) {
  return open(address, std::move(calls), Quotas{});
}

Result<std::unique_ptr<ConnectionGate>> ConnectionGate::open(const std::string& address,
                                                             std::shared_ptr<const CallBook> calls,
                                                             Quotas quotas) {
  DRIFTWISE_TRY(const auto where, socket_address_from(address));
  Descriptor socket(::socket(where.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  SocketAddress bound;
  bound.size = sizeof bound.bytes;
  remove_old_socket(where.bytes);
  int error = access::bind_door(socket.get(), reinterpret_cast<const sockaddr*>(&where.bytes),
                                static_cast<unsigned>(where.size));
  if (error == 0 &&
      (!keep_to_owner(where.bytes) || ::listen(socket.get(), SOMAXCONN) != 0 ||
       ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&bound.bytes), &bound.size) != 0))
    error = errno;
  if (error != 0)
    return fail(ErrorCode::unavailable, reasons::kAddressInUse,
                "cannot listen on " + address + " (" + std::strerror(error) +
                    "): is another driftwised running? Stop it, or give this door (listen of "
                    "[cell] or [access]) another port");
  return std::unique_ptr<ConnectionGate>(new ConnectionGate(
      std::make_unique<Listener>(std::move(socket), bound, std::move(calls), quotas)));
}

ConnectionGate::ConnectionGate(std::unique_ptr<Listener> listener)
    : listener_(std::move(listener)) {}
ConnectionGate::~ConnectionGate() = default;
std::uint16_t ConnectionGate::port() const { return listener_->port(); }
void ConnectionGate::accept_for(
    std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> server,
    void (*came)(const std::string&)) {
  listener_->accept_for(std::move(server), came);
}

}  // namespace driftwise::rpc
