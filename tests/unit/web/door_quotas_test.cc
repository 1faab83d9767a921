// Who makes room: the rules alone.

#include "server/web/door_quotas.h"

#include <gtest/gtest.h>

#include <vector>

#include "server/web/body_budget.h"

namespace driftwise::web {
namespace {

DoorInstant at(int seconds) { return DoorInstant(std::chrono::seconds(seconds)); }

class Room : public testing::Test {
 protected:
  void add(Activity activity, int since_s, const std::string& peer = "ipv4:127.0.0.1") {
    present.push_back({peer, activity, at(since_s)});
  }
  std::optional<std::size_t> goes(const std::string& newcomer = "ipv4:127.0.0.1") {
    return makes_room(present, newcomer, {.in_all = present.size(), .per_peer = 1000});
  }
  std::vector<ConnectionState> present;
};

TEST_F(Room, IsThereBelowTheQuotas) {
  add(Activity::idle, 0);
  EXPECT_FALSE(makes_room(present, "ipv4:127.0.0.1", {.in_all = 2, .per_peer = 2}));
  EXPECT_TRUE(makes_room(present, "ipv4:127.0.0.1", {.in_all = 2, .per_peer = 1}));
  EXPECT_FALSE(makes_room(present, "ipv4:127.0.0.2", {.in_all = 2, .per_peer = 1}));
}

TEST_F(Room, IsMadeByTheLongestIdleOne) {
  add(Activity::waiting, 1);
  add(Activity::idle, 7);
  add(Activity::idle, 5);
  EXPECT_EQ(goes(), 2U);
}

TEST_F(Room, IsMadeByAnUnfinishedRequestBeforeAnyStream) {
  add(Activity::blocked, 1);
  add(Activity::receiving, 9);
  add(Activity::answering, 2);
  EXPECT_EQ(goes(), 1U);
}

TEST_F(Room, IsMadeByTheSlowestStream) {
  add(Activity::waiting, 3);
  add(Activity::blocked, 8);
  add(Activity::blocked, 6);
  EXPECT_EQ(goes(), 2U) << "nobody takes its answers for longest";
}

TEST_F(Room, IsNeverMadeByAStop) {
  add(Activity::stopping, 1);
  add(Activity::answering, 5);
  EXPECT_EQ(goes(), 1U);
  present.pop_back();
  EXPECT_EQ(goes(), 1U) << "one past the end: the newcomer has to go";
}

TEST_F(Room, IsMadeByThePeerWithTheMostConnections) {
  add(Activity::idle, 1, "ipv4:127.0.0.9");
  add(Activity::waiting, 5);
  add(Activity::waiting, 4);
  EXPECT_EQ(goes("ipv4:127.0.0.8"), 2U);
}

constexpr std::size_t kMiB = std::size_t{1} << 20;

class Bodies : public testing::Test {
 protected:
  BodyBudget budget{{.in_all = 10 * kMiB, .per_peer = 8 * kMiB}};
  int closed = 0;
  std::unique_ptr<BodyBudget::Share> body(const std::string& peer = "a") {
    return std::make_unique<BodyBudget::Share>(budget, peer, [this] { ++closed; });
  }
};

TEST_F(Bodies, AreCountedUntilTheirAnswerIsOut) {
  auto first = body();
  EXPECT_TRUE(first->grow_to(6 * kMiB, at(0)));
  EXPECT_EQ(budget.bytes(), 6 * kMiB);
  auto second = body();
  EXPECT_FALSE(second->grow_to(3 * kMiB, at(0))) << "the peer's quota";
  EXPECT_TRUE(second->grow_to(2 * kMiB, at(0)));
  auto other = body("b");
  EXPECT_FALSE(other->grow_to(3 * kMiB, at(0))) << "the quota in all";
  first.reset();
  EXPECT_TRUE(other->grow_to(3 * kMiB, at(0)));
  EXPECT_EQ(closed, 0);
}

TEST_F(Bodies, ThatStallGiveWay) {
  auto stalled = body(), at_work = body();
  EXPECT_TRUE(stalled->grow_to(5 * kMiB, at(0)));
  EXPECT_TRUE(at_work->grow_to(2 * kMiB, at(0)));
  at_work->complete();
  auto next = body();
  EXPECT_TRUE(next->grow_to(6 * kMiB, at(2)));
  EXPECT_EQ(closed, 1);
  EXPECT_EQ(budget.bytes(), 8 * kMiB) << "what is at work stays";
}

TEST_F(Bodies, OfACallCostNothing) {
  auto file = body();
  EXPECT_TRUE(file->grow_to(8 * kMiB, at(0)));
  EXPECT_TRUE(body()->grow_to(1000, at(0))) << "a stop has a small body";
}

}  // namespace
}  // namespace driftwise::web
