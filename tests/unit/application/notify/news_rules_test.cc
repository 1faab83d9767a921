// What a receiver is told, and when.

#include "server/application/notify/news_rules.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

CellTime at(double s) { return CellTime{1'795'248'000'000'000'000} + nanoseconds_from_s(s); }

class NewsRules : public testing::Test {
 protected:
  NewsRules() {
    receiver.name = "duty";
    alarm.id = {1};
    alarm.level = AlarmLevel::failed;
    alarm.kind = "device.lost";
    alarm.subject = "laser";
    alarm.since = at(0);
    told.alarm = {1};
  }
  std::optional<DueNews> due(bool open = true, bool open_then = true) const {
    return due_news(
        {receiver, alarm, told.count > 0 ? &told : nullptr, at(-1000), open, open_then, now});
  }
  bool finished(bool open_then = true) const {
    return is_finished(
        {receiver, alarm, told.count > 0 ? &told : nullptr, at(-1000), true, open_then, now});
  }
  void tell(double s) {
    told.count = 1;
    told.firing = told.last = at(s);
  }
  ReceiverDescription receiver;
  AlarmRecord alarm;
  TellingRecord told;
  CellTime now = at(0);
};

TEST_F(NewsRules, AnAlarmIsToldAfterTheTimeOfItsGroup) {
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::firing);
  EXPECT_EQ(due()->at, at(10));
}

TEST_F(NewsRules, ItIsRepeatedUntilSomebodyHasSeenIt) {
  tell(10);
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::repeat);
  EXPECT_EQ(due()->at, at(10 + 4 * 3600));
  alarm.acknowledged = at(20);
  EXPECT_FALSE(due());
  EXPECT_FALSE(finished());  // its end is still to be told
}

TEST_F(NewsRules, ItsEndIsToldOnce) {
  tell(10);
  alarm.cleared = at(60);
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::resolved);
  told.resolved = at(61);
  EXPECT_FALSE(due());
  EXPECT_TRUE(finished());
  told.resolved = {};
  receiver.resolved = false;
  EXPECT_TRUE(finished());
}

TEST_F(NewsRules, OneThatWasOverBeforeItWasToldIsToldAllTheSame) {
  alarm.cleared = at(3);
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::firing);
}

TEST_F(NewsRules, AMomentaryOneIsOverWhenItIsAcknowledged) {
  alarm.cleared = alarm.since;
  tell(10);
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::repeat);
  alarm.acknowledged = at(30);
  ASSERT_TRUE(due());
  EXPECT_EQ(due()->kind, NewsKind::resolved);
}

TEST_F(NewsRules, AShelvedOneWaits) {
  alarm.shelved_until = at(3600);
  EXPECT_FALSE(due());
  EXPECT_FALSE(finished());
  tell(10);
  EXPECT_FALSE(due());
  alarm.cleared = at(60);
  EXPECT_TRUE(due());
}

TEST_F(NewsRules, OutsideItsHoursNothingIsToldUntilTheyBegin) {
  EXPECT_FALSE(due(false, false));
  EXPECT_TRUE(due(true, false));
  alarm.acknowledged = at(100);
  EXPECT_TRUE(finished(false));  // somebody has seen it meanwhile
  EXPECT_FALSE(finished(true));
}

TEST_F(NewsRules, WhatWasOverBeforeTheReceiverWasKnownIsNotTold) {
  alarm.since = at(-2000);
  alarm.cleared = at(-1500);
  EXPECT_TRUE(finished());
  alarm.cleared = at(-900);
  EXPECT_FALSE(finished());
}

TEST_F(NewsRules, WhatIsOverAndSeenIsNoNewsToWhoWasNotToldThatItBegan) {
  alarm.cleared = at(3600);
  EXPECT_FALSE(finished());
  alarm.acknowledged = at(4000);
  EXPECT_FALSE(due());
  EXPECT_TRUE(finished());
  tell(10);
  ASSERT_TRUE(due()) << "who was told that it began is told its end";
  EXPECT_EQ(due()->kind, NewsKind::resolved);
}

TEST_F(NewsRules, WhatHasBeenOverForSevenDaysIsNoNews) {
  alarm.cleared = at(60);
  now = at(60 + kForget_s);
  EXPECT_FALSE(finished());
  now = at(61 + kForget_s);
  EXPECT_FALSE(due());
  EXPECT_TRUE(finished());
}

TEST_F(NewsRules, LevelsAndKindsRoute) {
  receiver.levels = {"warning"};
  EXPECT_TRUE(finished());
  receiver.levels = {"warning", "failed"};
  EXPECT_FALSE(finished());
  receiver.kinds = {"run.*", "gate.spread"};
  EXPECT_TRUE(finished());
  receiver.kinds = {"device.*"};
  EXPECT_FALSE(finished());
  receiver.kinds.clear();
  alarm.kind = "notify.failed";
  alarm.subject = "duty";  // told to the others: this one takes nothing
  EXPECT_TRUE(finished());
  alarm.subject = "mail";
  EXPECT_FALSE(finished());
}

TEST(Hours, CrossMidnightOnTheDayOnWhichTheyBegin) {
  ReceiverDescription night;
  EXPECT_TRUE(in_hours(night, {3, 600}));  // without hours: always
  night.from_minute = 18 * 60;
  night.to_minute = 7 * 60;
  night.days = 1U << 4;  // Friday
  EXPECT_FALSE(in_hours(night, {4, 17 * 60 + 59}));
  EXPECT_TRUE(in_hours(night, {4, 18 * 60}));
  EXPECT_TRUE(in_hours(night, {5, 6 * 60 + 59}));  // Saturday morning
  EXPECT_FALSE(in_hours(night, {5, 7 * 60}));
  EXPECT_FALSE(in_hours(night, {5, 20 * 60}));
  EXPECT_FALSE(in_hours(night, {4, 3 * 60}));  // that of Thursday
  night.days = 1U << 6;                        // Sunday: the week goes round
  EXPECT_TRUE(in_hours(night, {0, 60}));
  ReceiverDescription day;
  day.from_minute = 8 * 60;
  day.to_minute = 17 * 60;
  EXPECT_TRUE(in_hours(day, {0, 8 * 60}));
  EXPECT_FALSE(in_hours(day, {0, 17 * 60}));
}

}  // namespace
}  // namespace driftwise::application
