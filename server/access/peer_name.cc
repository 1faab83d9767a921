#include "server/access/peer_name.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <charconv>
#include <optional>

namespace driftwise::access {
namespace {

constexpr std::string_view kV6 = "ipv6:[", kMapped = "::ffff:";

// "::ffff:10.0.0.2" -> "10.0.0.2"; nothing: it is no IPv4 address.
std::optional<std::string> unmapped(std::string_view address) {
  if (!address.starts_with(kMapped)) return std::nullopt;
  std::string v4(address.substr(kMapped.size()));
  in_addr number{};
  if (::inet_pton(AF_INET, v4.c_str(), &number) != 1) return std::nullopt;
  return v4;
}

std::string without_percent_code(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    unsigned char code = 0;
    const char* digits = text.data() + at + 1;
    const bool coded = text[at] == '%' && at + 2 < text.size() &&
                       std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    out += coded ? static_cast<char>(code) : text[at];
    if (coded) at += 2;
  }
  return out;
}

unsigned port_of(const sockaddr& address) {
  return ntohs(address.sa_family == AF_INET
                   ? reinterpret_cast<const sockaddr_in&>(address).sin_port
                   : reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
}

}  // namespace

std::string address_text_of(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.sa_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    return ::inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
  }
  if (address.sa_family != AF_INET6) return {};
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  std::string out = ::inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
  if (auto v4 = unmapped(out)) return *v4;
  // A link-local address is one of an interface.
  if (v6.sin6_scope_id != 0) out += "%" + std::to_string(v6.sin6_scope_id);
  return out;
}

std::string host_name_of(const sockaddr& address) {
  const std::string text = address_text_of(address);
  if (text.empty()) return "unix:";
  return text.find(':') == std::string::npos ? "ipv4:" + text : "ipv6:[" + text + "]";
}

std::string peer_name_of(const sockaddr& address) {
  const std::string host = host_name_of(address);
  return host == "unix:" ? host : host + ":" + std::to_string(port_of(address));
}

std::string peer_name_from_grpc(std::string_view printed) {
  // A client may have bound a path or an abstract name of its own: it is one of this computer.
  if (printed.starts_with("unix")) return "unix:";
  if (!printed.starts_with("ipv6:")) return std::string(printed);
  std::string name = without_percent_code(printed);
  const auto end = name.find(']');
  if (!name.starts_with(kV6) || end == std::string::npos) return name;
  if (const auto v4 = unmapped(std::string_view(name).substr(kV6.size(), end - kV6.size())))
    return "ipv4:" + *v4 + name.substr(end + 1);
  return name;
}

}  // namespace driftwise::access
