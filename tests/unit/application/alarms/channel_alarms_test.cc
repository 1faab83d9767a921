// Limits of a user's own.

#include "server/application/alarms/channel_alarms.h"

#include <gmock/gmock.h>

#include "server/core/data/reading.h"

namespace driftwise::application {
namespace {

using testing::IsEmpty;

class ChannelAlarmsTest : public testing::Test {
 protected:
  ChannelAlarmDescription rule{.channel = "t07_degC",
                               .above = 21.0,
                               .below = {},
                               .hysteresis = 0.5,
                               .for_s = 60,
                               .sentence = "open the door"};
  ChannelAlarms alarms{{rule}};
  std::vector<AlarmCondition> at(double s, double value) {
    const CellTime now{static_cast<std::int64_t>(s * 1e9)};
    alarms.take("t07_degC", "scanner", value, now);
    return alarms.conditions(now);
  }
};

TEST_F(ChannelAlarmsTest, BeginsWhenTheLimitWasPassedForLongEnough) {
  EXPECT_THAT(at(0, 21.5), IsEmpty());
  EXPECT_THAT(at(30, 20.9), IsEmpty());  // back: the time begins anew
  EXPECT_THAT(at(40, 21.5), IsEmpty());
  EXPECT_THAT(at(99, 21.5), IsEmpty());
  const auto found = at(100, 21.5);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind, "channel.limit");
  EXPECT_EQ(found[0].subject, "t07_degC above 21");
  EXPECT_EQ(found[0].level, AlarmLevel::warning);
  EXPECT_EQ(found[0].message,
            "t07_degC is 21.5: a limit of this cell file is above 21, over when it is 0.5 back. "
            "open the door");
}

TEST_F(ChannelAlarmsTest, IsOverWhenTheValueIsBackByTheHysteresis) {
  EXPECT_THAT(at(0, 22), IsEmpty());
  EXPECT_EQ(at(60, 22).size(), 1U);
  EXPECT_EQ(at(70, 20.6).size(), 1U);
  EXPECT_EQ(at(80, kMissing).size(), 1U);  // no value says nothing
  EXPECT_THAT(at(90, 20.5), IsEmpty());
  EXPECT_THAT(at(100, 20.9), IsEmpty());
}

TEST_F(ChannelAlarmsTest, OneOfBeforeTheStartNeedsNoTimeAgainAndEndsByItsHysteresis) {
  alarms.stand("channel.limit", "t07_degC above 21");
  EXPECT_FALSE(alarms.has_judged("channel.limit", "t07_degC above 21"));
  EXPECT_THAT(at(0, kMissing), IsEmpty()) << "nothing was read yet: no value to be told";
  EXPECT_FALSE(alarms.has_judged("channel.limit", "t07_degC above 21"));
  EXPECT_EQ(at(1, 20.6).size(), 1U) << "for_s is 60, and it is not back by 0.5";
  EXPECT_TRUE(alarms.has_judged("channel.limit", "t07_degC above 21"));
  EXPECT_THAT(at(2, 20.5), IsEmpty());
  EXPECT_TRUE(alarms.has_judged("channel.limit", "t07_degC above 25")) << "no limit any more";
}

TEST_F(ChannelAlarmsTest, CriticalIsAKindOfItsOwn) {
  rule.priority = "critical";
  rule.for_s = 0;
  rule.above.reset();
  rule.below = 19.0;
  alarms = ChannelAlarms({rule});
  const auto found = at(0, 18);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(priority_of(found[0].level, found[0].kind), AlarmPriority::critical);
  EXPECT_EQ(found[0].subject, "t07_degC below 19");
}

}  // namespace
}  // namespace driftwise::application
