#pragma once
// Keys of machines: one text for every way to name the same one. For locks, not for connecting.

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/transport/address.h"

namespace driftwise::transport {

// "tcp:192.168.1.7:50000"; an IPv4 address in IPv6 form counts as IPv4.
std::string tcp_key(const std::string& ip, std::uint16_t port);
// "serial:188:0", the device's number, whichever link leads to it; empty: there is no such device.
std::string serial_key(const std::string& path);
// Everything that an address resolves to now. A host name asks the resolver and may block for
// seconds; empty: it does not resolve.
std::vector<std::string> keys_of(const Address& address);

}  // namespace driftwise::transport
