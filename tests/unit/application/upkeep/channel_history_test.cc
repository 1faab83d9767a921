#include "server/application/recording/channel_history.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

CellTime at_s(double s) { return CellTime{} + nanoseconds_from_s(s); }

// A scan from start to end: its values belong to the middle.
Reading scan(double start_s, double end_s, double t03_degc) {
  return {"scanner", at_s(start_s), at_s(end_s), 0, {{"t03_degC", t03_degc}}};
}

TEST(ChannelHistory, JoinsLinearlyBetweenTheScansBeforeAndAfter) {
  ChannelHistory history;
  history.add(scan(9, 11, 20.0));
  history.add(scan(19, 21, 21.0));
  EXPECT_DOUBLE_EQ(history.at("t03_degC", at_s(12.5), 15)->value, 20.25);
  EXPECT_DOUBLE_EQ(history.at("t03_degC", at_s(12.5), 15)->age_s, 2.5);
}

TEST(ChannelHistory, TakesTheNearestWhenOnlyOneSideIsThere) {
  ChannelHistory history;
  history.add(scan(9, 11, 20.0));
  EXPECT_EQ(history.at("t03_degC", at_s(14), 15)->value, 20.0);
  EXPECT_EQ(history.at("t03_degC", at_s(2), 15)->value, 20.0);
}

TEST(ChannelHistory, DoesNotInterpolateOverAGapLongerThanTheMaximumAge) {
  ChannelHistory history;
  history.add(scan(10, 10, 20.0));
  history.add(scan(100, 100, 30.0));
  EXPECT_EQ(history.at("t03_degC", at_s(20), 15)->value, 20.0);
}

TEST(ChannelHistory, SaysHowOldAndWhichLimit) {
  ChannelHistory history;
  history.add(scan(10, 10, 20.0));
  const auto joined = history.at("t03_degC", at_s(32), 15);
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().reason, "CHANNEL_TOO_OLD");
  EXPECT_EQ(joined.error().message, "t03_degC too old: 22 s, limit 15 s");
}

TEST(ChannelHistory, DoesNotTakeABrokenProbeForASample) {
  ChannelHistory history;
  history.add(scan(10, 10, 20.0));
  history.add(scan(15, 15, kMissing));
  EXPECT_EQ(history.at("t03_degC", at_s(16), 15)->value, 20.0);
  EXPECT_EQ(history.at("t03_degC", at_s(26), 15).error().reason, "CHANNEL_TOO_OLD");
  EXPECT_EQ(history.latest("t03_degC")->at, at_s(10));
}

TEST(ChannelHistory, NamesAChannelThatNeverGaveAValue) {
  EXPECT_EQ(ChannelHistory().at("t09_degC", at_s(0), 15).error().reason, "CHANNEL_MISSING");
}

TEST(ChannelHistory, LeavesOutReadingsThatBeganBeforeAnInstant) {
  ChannelHistory history;
  history.add(scan(9, 11, 20.0));
  history.add(scan(14, 16, 30.0));
  history.add(scan(19, 21, 40.0));
  EXPECT_DOUBLE_EQ(history.at("t03_degC", at_s(15), 15, at_s(14))->value, 30.0);
  EXPECT_EQ(history.at("t03_degC", at_s(15), 15, at_s(14.5))->value, 40.0)
      << "the reading of the middle was under way already";
  EXPECT_FALSE(history.at("t03_degC", at_s(20), 15, at_s(19.5)));
}

TEST(ChannelHistory, KnowsSinceWhenADeviceWasReadWhateverItSaid) {
  ChannelHistory history;
  EXPECT_FALSE(history.has_reading_since("scanner", at_s(0)));
  history.add(scan(9, 11, kMissing));
  EXPECT_TRUE(history.has_reading_since("scanner", at_s(9)));
  EXPECT_FALSE(history.has_reading_since("scanner", at_s(10)));
  EXPECT_FALSE(history.has_reading_since("another", at_s(0)));
}

TEST(ChannelHistory, StaysBounded) {
  ChannelHistory history(4);
  for (int i = 0; i < 1000; ++i) history.add(scan(i, i, i));
  EXPECT_EQ(history.at("t03_degC", at_s(998.5), 15)->value, 998.5);
  EXPECT_FALSE(history.at("t03_degC", at_s(900), 15));
}

}  // namespace
}  // namespace driftwise::application
