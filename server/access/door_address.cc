#include "server/access/door_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace driftwise::access {

int bind_door(int socket, const sockaddr* where, unsigned size) {
  if (::bind(socket, where, size) == 0) return 0;
  if (errno != EADDRNOTAVAIL) return errno;
  const bool v6 = where->sa_family == AF_INET6;
  const int on = 1;
  ::setsockopt(socket, v6 ? SOL_IPV6 : SOL_IP, v6 ? IPV6_FREEBIND : IP_FREEBIND, &on, sizeof on);
  return ::bind(socket, where, size) == 0 ? 0 : errno;
}

bool is_absent(const std::string& address) {
  std::string host = address.substr(0, address.rfind(':'));
  const bool v6 = host.starts_with('[') && host.ends_with(']');
  if (v6) host = host.substr(1, host.size() - 2);
  sockaddr_storage where{};
  where.ss_family = v6 ? AF_INET6 : AF_INET;
  void* number = v6 ? static_cast<void*>(&reinterpret_cast<sockaddr_in6*>(&where)->sin6_addr)
                    : &reinterpret_cast<sockaddr_in*>(&where)->sin_addr;
  if (::inet_pton(where.ss_family, host.c_str(), number) != 1) return false;
  // Port 0: the kernel's answer does not depend on who has the port.
  const int socket = ::socket(where.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  const bool absent = ::bind(socket, reinterpret_cast<sockaddr*>(&where),
                             v6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in)) != 0 &&
                      errno == EADDRNOTAVAIL;
  ::close(socket);
  return absent;
}

}  // namespace driftwise::access
