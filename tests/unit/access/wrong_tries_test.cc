#include "server/access/wrong_tries.h"

#include <gtest/gtest.h>

namespace driftwise::access {
namespace {

using namespace std::chrono_literals;
const WrongTries::Instant kBegin{1000h};

TEST(WrongTries, PausesAfterSomeAndDoublesThePause) {
  WrongTries tries;
  auto now = kBegin;
  for (int i = 1; i < WrongTries::kFree; ++i) EXPECT_EQ(tries.wrong("a", now).pause, 0ms);
  for (const auto pause : {1s, 2s, 4s, 8s, 16s, 32s, 60s, 60s}) {
    EXPECT_EQ(tries.must_wait("a", now), 0ms);
    EXPECT_EQ(tries.wrong("a", now).pause, pause);
    EXPECT_EQ(tries.must_wait("a", now), pause);
    EXPECT_EQ(tries.must_wait("b", now), 0ms) << "another address is not slowed";
    now += pause;
  }
}

TEST(WrongTries, ForgetsAfterARightOneAndAfterAnHour) {
  WrongTries tries;
  for (int i = 0; i < 10; ++i) tries.wrong("a", kBegin);
  tries.right("a");
  EXPECT_EQ(tries.wrong("a", kBegin).tries, 1);
  for (int i = 0; i < 10; ++i) tries.wrong("b", kBegin);
  EXPECT_EQ(tries.wrong("b", kBegin + WrongTries::kForgotten + 1s).tries, 1);
}

TEST(WrongTries, KeepABoundedNumberOfAddresses) {
  WrongTries tries;
  for (int i = 0; i < 5; ++i) tries.wrong("first", kBegin);
  for (std::size_t i = 0; i < 2 * WrongTries::kMostKept; ++i)
    tries.wrong(std::to_string(i), kBegin + std::chrono::seconds(i));
  EXPECT_EQ(tries.wrong("first", kBegin + 100s).tries, 1) << "the oldest one went";
}

TEST(WrongTries, CountByAddressWithoutPort) {
  EXPECT_EQ(source_of("ipv4:10.0.0.2:4711"), "ipv4:10.0.0.2");
  EXPECT_EQ(source_of("unix:"), "unix");
  EXPECT_EQ(source_of("ipv6:[2001:db8:1:2:3:4:5:6]:4711"), "ipv6:[2001:db8:1:2");
  EXPECT_EQ(source_of("ipv6:[2001:db8:1:2:ffff::9]:4712"), "ipv6:[2001:db8:1:2");
  EXPECT_EQ(source_of("ipv6:[2001:db8::9]:1"), "ipv6:[2001:db8");
}

}  // namespace
}  // namespace driftwise::access
