#include "server/access/peer_name.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "server/access/wrong_tries.h"

namespace driftwise::access {
namespace {

sockaddr_in6 v6(const char* text, std::uint16_t port, std::uint32_t scope = 0) {
  sockaddr_in6 out{};
  out.sin6_family = AF_INET6;
  out.sin6_port = htons(port);
  out.sin6_scope_id = scope;
  if (::inet_pton(AF_INET6, text, &out.sin6_addr) != 1) throw std::runtime_error(text);
  return out;
}

const sockaddr& as_address(const sockaddr_in6& one) {
  return reinterpret_cast<const sockaddr&>(one);
}

TEST(PeerName, IsTheSameOfASocketAndOfWhatGrpcPrints) {
  EXPECT_EQ(peer_name_of(as_address(v6("::1", 51558))), "ipv6:[::1]:51558");
  EXPECT_EQ(peer_name_from_grpc("ipv6:%5B::1%5D:51558"), "ipv6:[::1]:51558");
  EXPECT_EQ(peer_name_of(as_address(v6("::ffff:127.0.0.1", 5020))), "ipv4:127.0.0.1:5020");
  EXPECT_EQ(peer_name_from_grpc("ipv4:127.0.0.1:5020"), "ipv4:127.0.0.1:5020");
  EXPECT_EQ(peer_name_from_grpc("ipv6:%5B::ffff:127.0.0.1%5D:5020"), "ipv4:127.0.0.1:5020");
  EXPECT_EQ(peer_name_of(as_address(v6("fe80::7", 80, 2))), "ipv6:[fe80::7%2]:80");
  EXPECT_EQ(peer_name_from_grpc("ipv6:%5Bfe80::7%252%5D:80"), "ipv6:[fe80::7%2]:80");
  sockaddr local{};
  local.sa_family = AF_UNIX;
  EXPECT_EQ(peer_name_of(local), "unix:");
  EXPECT_EQ(peer_name_from_grpc("unix:"), "unix:");
  EXPECT_EQ(peer_name_from_grpc("unix:/run/one"), "unix:");
}

TEST(PeerName, TellsTheHostWithoutThePort) {
  EXPECT_EQ(host_name_of(as_address(v6("2001:db8::7", 80))), "ipv6:[2001:db8::7]");
  EXPECT_EQ(host_name_of(as_address(v6("::ffff:10.0.0.2", 80))), "ipv4:10.0.0.2");
  EXPECT_EQ(address_text_of(as_address(v6("::ffff:192.0.2.2", 80))), "192.0.2.2");
}

TEST(PeerName, LeavesOtherTextsAsTheyAre) {
  for (const char* text : {"inproc:1", "unknown", "", "ipv6:%", "ipv6:%5", "ipv6:%zz"})
    EXPECT_EQ(peer_name_from_grpc(text), text);
}

TEST(PeerName, GivesLimitsOfOneNetworkTheSameSource) {
  EXPECT_EQ(source_of(peer_name_from_grpc("ipv6:%5B2001:db8:1:2:3::7%5D:51558")),
            source_of(peer_name_of(as_address(v6("2001:db8:1:2:9::8", 4)))));
}

}  // namespace
}  // namespace driftwise::access
