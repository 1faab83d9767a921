#pragma once
// Name of the other end of a connection, the same text at every door: "ipv4:10.0.0.2:4711",
// "ipv6:[fd00::7]:4711", "unix:". An IPv4 address that reached an IPv6 socket (::ffff:10.0.0.2) is
// the IPv4 address that it is.

#include <string>
#include <string_view>

struct sockaddr;

namespace driftwise::access {

// Without the port: "ipv4:10.0.0.2", "ipv6:[fd00::7]", "unix:"; for limits of one address.
std::string host_name_of(const sockaddr& address);
// With it.
std::string peer_name_of(const sockaddr& address);
// The address alone: "10.0.0.2", "fd00::7"; empty for a unix socket.
std::string address_text_of(const sockaddr& address);
// Of what gRPC prints, which writes IPv6 as a part of a URI: "ipv6:%5Bfd00::7%5D:4711". Any other
// text stays as it is.
std::string peer_name_from_grpc(std::string_view printed);

}  // namespace driftwise::access
