#pragma once
// Address of a door and the computer's own addresses. After a power cut the computer may be up
// before its network: a door opens all the same, and is reached as soon as the address is there.

#include <string>

struct sockaddr;

namespace driftwise::access {

// bind(2), also to an address that no interface has yet (IP_FREEBIND). Result: 0 or errno.
int bind_door(int socket, const sockaddr* where, unsigned size);

// This computer does not have the address of "192.168.7.1:50052" now. False for a host that is no
// number.
bool is_absent(const std::string& address);

}  // namespace driftwise::access
