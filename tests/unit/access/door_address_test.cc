#include "server/access/door_address.h"

#include <gtest/gtest.h>

namespace driftwise::access {
namespace {

TEST(DoorAddress, IsAbsentWhereNoInterfaceHasIt) {
  // TEST-NET-1 (RFC 5737) and the documentation's IPv6 prefix (RFC 3849): no computer's addresses.
  EXPECT_TRUE(is_absent("192.0.2.1:50052"));
  EXPECT_TRUE(is_absent("[2001:db8::1]:50052"));
  EXPECT_FALSE(is_absent("127.0.0.1:50052"));
  EXPECT_FALSE(is_absent("0.0.0.0:8443"));
  EXPECT_FALSE(is_absent("cell7.lab.example:8443")) << "no number";
  EXPECT_FALSE(is_absent("")) << "no door";
}

}  // namespace
}  // namespace driftwise::access
