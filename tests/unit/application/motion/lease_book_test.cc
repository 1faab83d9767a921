#include "server/application/motion/lease_book.h"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>

#include "server/application/cell/cell.h"

namespace driftwise::application {
namespace {

using std::chrono::seconds;
const Caller kAda{"ada", "ipv4:127.0.0.1:1", {}}, kBob{"bob", "ipv4:127.0.0.1:2", {}};
constexpr CellTime kStart{1'000'000'000'000};

// Name and peer alone would stand in the audit as a name that is only stated.
static_assert(!std::is_constructible_v<Caller, std::string, std::string>);

TEST(LeaseBook, GivesTheLeaseToOneClientAtATime) {
  LeaseBook book;
  const auto ada = book.take(kAda, seconds(60), "", kStart);
  ASSERT_TRUE(ada);
  EXPECT_TRUE(book.check(ada->token, kStart));
  const auto bob = book.take(kBob, seconds(60), "", kStart + seconds(59));
  ASSERT_FALSE(bob);
  EXPECT_EQ(bob.error().reason, "LEASE_HELD");
  EXPECT_NE(bob.error().message.find("ada"), std::string::npos);
  EXPECT_NE(bob.error().message.find("--lease-token"), std::string::npos)
      << "who took it in another terminal is no stranger";
}

TEST(LeaseBook, LetsAnotherTakeOverOnlyAfterItRanOut) {
  LeaseBook book;
  const auto ada = book.take(kAda, seconds(60), "", kStart);
  EXPECT_EQ(book.check(ada->token, kStart + seconds(60)).error().reason, "LEASE_EXPIRED");
  const auto bob = book.take(kBob, seconds(60), "", kStart + seconds(60));
  ASSERT_TRUE(bob);
  EXPECT_EQ(book.check(ada->token, kStart + seconds(61)).error().reason, "LEASE_HELD");
  EXPECT_EQ(book.take(kAda, seconds(60), ada->token, kStart + seconds(61)).error().code,
            ErrorCode::permission_denied);
}

TEST(LeaseBook, RenewsWithTheToken) {
  LeaseBook book;
  const auto ada = book.take(kAda, seconds(60), "", kStart);
  ASSERT_TRUE(book.take(kAda, seconds(60), ada->token, kStart + seconds(50)));
  EXPECT_TRUE(book.check(ada->token, kStart + seconds(100)));
}

TEST(LeaseBook, AsksForATokenAndShowsNone) {
  LeaseBook book;
  EXPECT_EQ(book.check("", kStart).error().reason, "LEASE_REQUIRED");
  EXPECT_EQ(book.check("guess", kStart).error().reason, "LEASE_UNKNOWN");
  book.take(kAda, seconds(60), "", kStart);
  ASSERT_TRUE(book.present(kStart));
  EXPECT_TRUE(book.present(kStart)->token.empty());
  EXPECT_EQ(book.present(kStart)->holder, "ada");
}

TEST(LeaseBook, IsFreeOnceGivenUp) {
  LeaseBook book;
  const auto ada = book.take(kAda, seconds(60), "", kStart);
  EXPECT_FALSE(book.give_up("guess", kStart));
  EXPECT_TRUE(book.give_up(ada->token, kStart));
  EXPECT_TRUE(book.take(kBob, seconds(60), "", kStart));
}

TEST(LeaseBook, AStopEndsTheLeaseForGood) {
  LeaseBook book;
  book.end("nobody held one");
  const auto ada = book.take(kAda, seconds(60), "", kStart);
  book.end("stopped by bob");
  const auto refused = book.check(ada->token, kStart);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "STOPPED_MEANWHILE");
  EXPECT_EQ(refused.error().code, ErrorCode::aborted);
  EXPECT_NE(refused.error().message.find("stopped by bob"), std::string::npos);
  EXPECT_FALSE(book.take(kAda, seconds(60), ada->token, kStart)) << "it is not renewed";
  EXPECT_FALSE(book.present(kStart));
  const auto again = book.take(kAda, seconds(60), "", kStart);
  ASSERT_TRUE(again);
  EXPECT_TRUE(book.check(again->token, kStart));
  EXPECT_EQ(book.check(ada->token, kStart).error().reason, "STOPPED_MEANWHILE");
}

TEST(LeaseBook, RefusesUnreasonableDurations) {
  LeaseBook book;
  EXPECT_EQ(book.take(kAda, seconds(0), "", kStart).error().reason, "LEASE_DURATION");
  EXPECT_EQ(book.take(kAda, std::chrono::hours(2), "", kStart).error().reason, "LEASE_DURATION");
}

}  // namespace
}  // namespace driftwise::application
