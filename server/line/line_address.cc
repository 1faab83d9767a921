#include "server/line/line_address.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::line {
namespace {

namespace ip = boost::asio::ip;
using Bytes = std::vector<unsigned char>;

Bytes bytes_of(const ip::address& address) {
  if (address.is_v4()) {
    const auto raw = address.to_v4().to_bytes();
    return {raw.begin(), raw.end()};
  }
  const auto v6 = address.to_v6();
  if (v6.is_v4_mapped()) return bytes_of(ip::make_address_v4(ip::v4_mapped, v6));
  const auto raw = v6.to_bytes();
  return {raw.begin(), raw.end()};
}

bool same_prefix(const Bytes& a, const Bytes& b, unsigned bits) {
  if (a.size() != b.size()) return false;
  for (unsigned i = 0; i < bits; ++i)
    if (((a[i / 8] ^ b[i / 8]) & (0x80U >> i % 8)) != 0) return false;
  return true;
}

// Of a sockaddr of the two internet families; else empty.
Bytes bytes_of(const sockaddr* address) {
  if (address == nullptr) return {};
  Bytes out;
  if (address->sa_family == AF_INET) {
    out.resize(4);
    std::memcpy(out.data(), &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, 4);
  } else if (address->sa_family == AF_INET6) {
    out.resize(16);
    std::memcpy(out.data(), &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr, 16);
  }
  return out;
}

std::string text_of(const Bytes& bytes) {
  if (bytes.size() == 4) {
    ip::address_v4::bytes_type raw;
    std::memcpy(raw.data(), bytes.data(), raw.size());
    return ip::address_v4(raw).to_string();
  }
  ip::address_v6::bytes_type raw;
  std::memcpy(raw.data(), bytes.data(), raw.size());
  return ip::address_v6(raw).to_string();
}

// Loopback interfaces answer to every address of their network.
bool has_address(const ifaddrs& one, const Bytes& wanted) {
  const Bytes own = bytes_of(one.ifa_addr);
  if (own == wanted) return true;
  const Bytes mask = bytes_of(one.ifa_netmask);
  if ((one.ifa_flags & IFF_LOOPBACK) == 0 || own.size() != wanted.size() ||
      mask.size() != wanted.size())
    return false;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (((own[i] ^ wanted[i]) & mask[i]) != 0) return false;
  return true;
}

}  // namespace

Result<ip::tcp::endpoint> endpoint_from(const std::string& address) {
  const auto bad = [&] {
    return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
                "target_line: found '" + address + "', expected host:port such as 127.0.0.1:50052");
  };
  const auto colon = address.rfind(':');
  if (colon == std::string::npos) return bad();
  std::string host = address.substr(0, colon);
  std::uint16_t port = 0;
  const char* end = address.data() + address.size();
  const auto [after, code] = std::from_chars(address.data() + colon + 1, end, port);
  if (code != std::errc{} || after != end) return bad();
  if (host == "localhost") host = "127.0.0.1";
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  boost::system::error_code error;
  const auto found = ip::make_address(host, error);
  if (error) return bad();
  return ip::tcp::endpoint(found, port);
}

std::string text_of(const ip::tcp::endpoint& end) {
  const std::string host = end.address().to_string();
  return (end.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(end.port());
}

Result<void> check_interface(const std::string& interface, const ip::address& address) {
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0)
    return fail(ErrorCode::unavailable, reasons::kNotOnInterface,
                "plain_target_line: the addresses of the interface '" + interface +
                    "' cannot be read: " + std::strerror(errno) +
                    "; under systemd RestrictAddressFamilies of the unit needs AF_NETLINK");
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> all(first, ::freeifaddrs);
  const Bytes wanted = bytes_of(address);
  std::string has;
  for (const ifaddrs* one = all.get(); one != nullptr; one = one->ifa_next) {
    const Bytes own = bytes_of(one->ifa_addr);
    if (own.empty()) continue;
    const bool here = interface == one->ifa_name;
    if (here && has_address(*one, wanted)) return {};
    // IPv6 gives every interface an address of its own.
    if (here ? own.size() == wanted.size() : own == wanted)
      has += (has.empty() ? "" : ", ") + text_of(own) +
             (here ? "" : " of " + std::string(one->ifa_name));
  }
  if (has.empty()) return {};
  return fail(ErrorCode::failed_precondition, reasons::kNotOnInterface,
              "plain_target_line: " + address.to_string() + " is no address of the interface '" +
                  interface + "'; found " + has + "; correct plain_target_line or plain_interface");
}

Result<AddressList> AddressList::from(const std::vector<std::string>& entries) {
  if (entries.empty())
    return fail(ErrorCode::invalid_argument, reasons::kMissingKey,
                "plain_allow: expected the addresses of the controllers that may ask, such as "
                "\"192.168.7.10\"");
  AddressList out;
  for (const auto& entry : entries) {
    const auto slash = entry.find('/');
    boost::system::error_code bad;
    const auto address = ip::make_address(entry.substr(0, slash), bad);
    Network network;
    if (!bad) network.bytes = bytes_of(address);
    network.bits = static_cast<unsigned>(8 * network.bytes.size());
    bool good = !bad;
    if (good && slash != std::string::npos) {
      unsigned bits = 0;
      const char* end = entry.data() + entry.size();
      const auto [after, code] = std::from_chars(entry.data() + slash + 1, end, bits);
      good = code == std::errc{} && after == end && bits >= 8 && bits <= network.bits;
      network.bits = bits;
    }
    if (!good)
      return fail(ErrorCode::invalid_argument, reasons::kBadAddress,
                  "plain_allow: found '" + entry +
                      "', expected an address or a network of at least 8 bits: 192.168.7.10, "
                      "192.168.7.0/24");
    out.networks_.push_back(std::move(network));
  }
  return out;
}

bool AddressList::holds(const ip::address& address) const {
  const Bytes bytes = bytes_of(address);
  for (const auto& one : networks_)
    if (same_prefix(one.bytes, bytes, one.bits)) return true;
  return false;
}

}  // namespace driftwise::line
