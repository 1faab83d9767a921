#include "server/access/failed_handshakes.h"

#include <gmock/gmock.h>

namespace driftwise::access {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;
const FailedHandshakes::Instant kBegin{std::chrono::hours(7)};

TEST(FailedHandshakes, AreToldWithTheDoorTheClientAndWhatToDo) {
  FailedHandshakes door("page on 10.0.0.1:8443");
  const auto told = door.note("ipv4:10.0.0.7", "certificate verify failed (SSL routines)", kBegin);
  ASSERT_TRUE(told);
  EXPECT_EQ(
      *told,
      "page on 10.0.0.1:8443: the TLS handshake with ipv4:10.0.0.7 failed: certificate verify "
      "failed (SSL routines); the client's certificate has ended, or another authority signed "
      "it: make one with 'driftwise cert client'");
}

TEST(FailedHandshakes, OfOneClientAreToldOnceAMinuteWithTheNumberOfTheOthers) {
  FailedHandshakes door("text line");
  EXPECT_TRUE(door.note("ipv4:10.0.0.7", "x", kBegin));
  for (int i = 0; i < 300; ++i)
    EXPECT_FALSE(door.note("ipv4:10.0.0.7", "x", kBegin + std::chrono::milliseconds(100 * i)));
  EXPECT_TRUE(door.note("ipv4:10.0.0.8", "x", kBegin + seconds(1)));
  const auto again = door.note("ipv4:10.0.0.7", "x", kBegin + seconds(60));
  ASSERT_TRUE(again);
  EXPECT_THAT(*again, HasSubstr("300 more from there before"));
}

TEST(FailedHandshakes, KeepABoundedNumberOfClients) {
  FailedHandshakes door("text line");
  const auto peer = [](std::size_t i) { return "ipv6:[2001:db8::" + std::to_string(i) + "]"; };
  for (std::size_t i = 0; i <= FailedHandshakes::kMostKept; ++i)
    EXPECT_TRUE(door.note(peer(i), "x", kBegin + std::chrono::milliseconds(i)));
  // The first made room for the last, the second is known still.
  EXPECT_TRUE(door.note(peer(0), "x", kBegin + seconds(2)));
  EXPECT_FALSE(door.note(peer(2), "x", kBegin + seconds(2)));
}

TEST(FailedHandshakes, LeaveControlCharactersOfAClientOutOfTheLog) {
  FailedHandshakes door("text line");
  EXPECT_THAT(*door.note("p", "bad\nlevel=info forged", kBegin), testing::Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace driftwise::access
