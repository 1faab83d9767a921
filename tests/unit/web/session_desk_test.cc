// Sessions, cookies, links and rates by themselves, with instants that the test chooses.

#include "server/web/session_desk.h"

#include <gmock/gmock.h>

#include "server/access/page_links.h"
#include "server/web/request_rate.h"

namespace driftwise::web {
namespace {

using std::chrono::seconds;
const SessionDesk::Instant kNow{};

access::Identity ada() {
  return {"ada", access::Role::operator_, access::Proof::token, "k3f9a2c1", "ipv4:10.0.0.2:4711"};
}

TEST(Sessions, EndByTime) {
  SessionDesk desk({.longest = seconds(60)});
  const auto cookie = desk.begin(ada(), kNow);
  ASSERT_NE(desk.find(cookie, kNow + seconds(59)), nullptr);
  EXPECT_EQ(desk.find(cookie, kNow + seconds(59))->who.proof, access::Proof::page_session);
  EXPECT_EQ(desk.find(cookie, kNow + seconds(60)), nullptr);
  EXPECT_EQ(desk.size(), 0U);
}

TEST(Sessions, EndByLogOutAndWithTheirToken) {
  SessionDesk desk({});
  const auto first = desk.begin(ada(), kNow), second = desk.begin(ada(), kNow);
  EXPECT_TRUE(desk.end(first));
  EXPECT_FALSE(desk.end(first));
  EXPECT_NE(desk.find(second, kNow), nullptr);
  auto eve = ada();
  eve.credential = "m4g0b3d2";
  const auto other = desk.begin(std::move(eve), kNow);
  desk.end_unless([](const access::Identity& who) { return who.credential != "k3f9a2c1"; });
  EXPECT_EQ(desk.find(second, kNow), nullptr);
  EXPECT_NE(desk.find(other, kNow), nullptr);
}

TEST(Sessions, AreBounded) {
  SessionDesk desk({.in_all = 10, .of_one_name = 3});
  std::vector<std::string> cookies;
  for (int i = 0; i < 5; ++i) cookies.push_back(desk.begin(ada(), kNow + seconds(i)));
  EXPECT_EQ(desk.size(), 3U) << "of one name";
  EXPECT_EQ(desk.find(cookies[1], kNow), nullptr) << "the oldest went";
  EXPECT_NE(desk.find(cookies[4], kNow), nullptr);
  for (int i = 0; i < 50; ++i) {
    auto other = ada();
    other.name += std::to_string(i);
    desk.begin(std::move(other), kNow + seconds(i));
  }
  EXPECT_EQ(desk.size(), 10U);
}

TEST(Cookie, IsFoundAmongOthersAndOnlyWhenItStandsOnce) {
  EXPECT_EQ(cookie_value("a=1; driftwise-8080=xyz; b=2", "driftwise-8080"), "xyz");
  EXPECT_EQ(cookie_value("driftwise-80801=no; xdriftwise-8080=no", "driftwise-8080"), "");
  EXPECT_EQ(cookie_value("driftwise-8080=one; driftwise-8080=two", "driftwise-8080"), "");
  EXPECT_EQ(cookie_value(";;= ;driftwise-8080", "driftwise-8080"), "");
  EXPECT_EQ(cookie_value("", "driftwise-8080"), "");
}

TEST(PageLink, WorksOnceAndForTwoMinutes) {
  access::PageLinks links;
  const auto link = links.make(ada(), kNow), late = links.make(ada(), kNow);
  EXPECT_FALSE(links.use(link + "x", kNow));
  EXPECT_EQ(links.use(link, kNow + seconds(1)), ada());
  EXPECT_FALSE(links.use(link, kNow + seconds(1))) << "used";
  EXPECT_FALSE(links.use(late, kNow + access::PageLinks::kLife)) << "too old";
}

TEST(PageLink, GoesWhenManyOthersWereMadeAfterIt) {
  access::PageLinks links;
  const auto first = links.make(ada(), kNow);
  for (std::size_t i = 0; i < access::PageLinks::kMostOpen; ++i)
    links.make(ada(), kNow + seconds(1));
  EXPECT_FALSE(links.use(first, kNow + seconds(1)));
}

TEST(Rate, TakesABurstThenSoManyASecondFromEachAddress) {
  RequestRate rate;
  int taken = 0;
  while (rate.takes("ipv4:10.0.0.2", kNow)) ++taken;
  EXPECT_EQ(taken, static_cast<int>(RequestRate::kBurst));
  EXPECT_TRUE(rate.takes("ipv4:10.0.0.3", kNow)) << "another one";
  taken = 0;
  while (rate.takes("ipv4:10.0.0.2", kNow + seconds(2))) ++taken;
  EXPECT_EQ(taken, static_cast<int>(2 * RequestRate::kPerSecond));
}

TEST(Rate, RemembersABoundedNumberOfAddresses) {
  RequestRate rate;
  for (std::size_t i = 0; i < RequestRate::kMostKept + 100; ++i)
    rate.takes("ipv4:" + std::to_string(i), kNow + std::chrono::milliseconds(i));
  EXPECT_EQ(rate.size(), RequestRate::kMostKept);
}

}  // namespace
}  // namespace driftwise::web
