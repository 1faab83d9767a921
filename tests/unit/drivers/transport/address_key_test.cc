// One key for every way to name the same machine.

#include "drivers/transport/address_key.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>

namespace driftwise::transport {
namespace {

TEST(AddressKey, IsTheSameForEveryFormOfOneTcpAddress) {
  EXPECT_EQ(tcp_key("192.168.1.7", 50000), "tcp:192.168.1.7:50000");
  EXPECT_EQ(tcp_key("::ffff:192.168.1.7", 50000), "tcp:192.168.1.7:50000");
  EXPECT_EQ(tcp_key("0:0:0:0:0:0:0:1", 7), tcp_key("::1", 7));
  EXPECT_NE(tcp_key("192.168.1.7", 50001), tcp_key("192.168.1.7", 50000));
  EXPECT_THAT(keys_of(*parse_address("localhost:50000")), testing::Contains("tcp:127.0.0.1:50000"));
  EXPECT_THAT(keys_of(*parse_address("no-such-host.invalid:1")), testing::IsEmpty());
}

TEST(AddressKey, OfASerialPortIsTheDeviceWhicheverLinkLeadsToIt) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(grantpt(terminal), 0);
  ASSERT_EQ(unlockpt(terminal), 0);
  const std::string path = ptsname(terminal);
  const std::string link = testing::TempDir() + "/driftwise-axis-" + std::to_string(getpid());
  std::filesystem::remove(link);
  std::filesystem::create_symlink(path, link);
  EXPECT_THAT(serial_key(path), testing::StartsWith("serial:"));
  EXPECT_EQ(serial_key(link), serial_key(path));
  EXPECT_EQ(serial_key("/dev/no-such-port"), "");
  EXPECT_EQ(serial_key("/etc/hostname"), "") << "a file is no port";
  std::filesystem::remove(link);
  close(terminal);
}

}  // namespace
}  // namespace driftwise::transport
