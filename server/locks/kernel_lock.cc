#include "server/locks/kernel_lock.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>

#include "server/core/reasons.h"

namespace driftwise::locks {
namespace {

constexpr const char* kPrefix = "driftwise/";

struct Address {
  sockaddr_un value{};
  socklen_t size = 0;
};

Address address_of(const std::string& name) {
  Address address;
  address.value.sun_family = AF_UNIX;
  // Byte 0 of the path stays 0: that makes the name abstract.
  const std::string path = (kPrefix + name).substr(0, sizeof address.value.sun_path - 1);
  std::memcpy(address.value.sun_path + 1, path.data(), path.size());
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + path.size());
  return address;
}

int new_socket() { return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

// The process that listens at the name, by the kernel's word.
std::string holder_of(const Address& address) {
  const std::string unknown = "another process";
  const int probe = new_socket();
  if (probe < 0) return unknown;
  ucred who{};
  socklen_t size = sizeof who;
  const bool known =
      connect(probe, reinterpret_cast<const sockaddr*>(&address.value), address.size) == 0 &&
      getsockopt(probe, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && who.pid > 0;
  close(probe);
  return known ? "process " + std::to_string(who.pid) : unknown;
}

}  // namespace

Result<KernelLock> KernelLock::take(const std::string& name) {
  const Address address = address_of(name);
  const int socket = new_socket();
  if (socket < 0)
    return fail(ErrorCode::internal, reasons::kNoLock,
                "no socket for the lock " + name + ": " + std::strerror(errno));
  KernelLock lock(socket);
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address.value), address.size) != 0) {
    if (errno == EADDRINUSE)
      return fail(ErrorCode::failed_precondition, reasons::kLockHeld, holder_of(address));
    return fail(ErrorCode::internal, reasons::kNoLock,
                "cannot take the lock " + name + ": " + std::strerror(errno));
  }
  // Listening tells who asks which process this is. Nothing is ever accepted.
  constexpr int kBacklog = 64;
  static_cast<void>(listen(socket, kBacklog));
  return lock;
}

KernelLock::~KernelLock() {
  if (socket_ >= 0) close(socket_);
}

}  // namespace driftwise::locks
