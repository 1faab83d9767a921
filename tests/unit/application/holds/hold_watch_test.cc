// A limit of the cell over a series of values: when it holds and when it lets go.

#include "server/application/holds/hold_watch.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using Phase = HoldWatch::Phase;
using testing::HasSubstr;

constexpr CellTime kBegin{1'000'000'000'000};

HoldRule room() {
  HoldRule rule;
  rule.name = "room";
  rule.channel = "t12_degC";
  rule.above = 20.5;
  rule.release_above = 20.3;
  rule.for_s = 60;
  rule.settle_s = 600;
  return rule;
}

class HoldWatchTest : public testing::Test {
 protected:
  HoldWatch watch_{room()};
  Phase at(double s, std::optional<double> value, HoldWatch::Look look = HoldWatch::Look::usual) {
    watch_.look(value, kBegin + nanoseconds_from_s(s), look);
    return watch_.phase();
  }
};

TEST_F(HoldWatchTest, TheLimitItselfIsNotExceeded) { EXPECT_EQ(at(0, 20.5), Phase::clear); }

TEST_F(HoldWatchTest, AShortExcursionIsNone) {
  EXPECT_EQ(at(0, 21), Phase::exceeded);
  EXPECT_EQ(at(59, 21), Phase::exceeded);
  EXPECT_EQ(at(59.5, 20.4), Phase::clear);
  EXPECT_EQ(at(60, 21), Phase::exceeded);  // counted anew
  EXPECT_EQ(at(119, 21), Phase::exceeded);
  EXPECT_EQ(at(120, 21), Phase::holding);
}

TEST_F(HoldWatchTest, EndsAfterTheSettlingTimeWithinTheReleaseLimitWithoutABreak) {
  at(0, 21);
  EXPECT_EQ(at(60, 21), Phase::holding);
  EXPECT_EQ(at(100, 20.4), Phase::holding);  // below the limit, not yet below the release
  EXPECT_EQ(at(1000, 20.4), Phase::holding);
  EXPECT_FALSE(watch_.settles());
  EXPECT_EQ(at(1001, 20.3), Phase::holding);
  EXPECT_TRUE(watch_.settles());
  EXPECT_EQ(at(1500, 20.31), Phase::holding);  // a break
  EXPECT_FALSE(watch_.settles());
  EXPECT_EQ(at(1501, 20.2), Phase::holding);
  EXPECT_EQ(at(2100, 20.2), Phase::holding);
  EXPECT_EQ(at(2101, 20.2), Phase::clear);
  EXPECT_EQ(watch_.since().utc_ns, 0);
}

TEST_F(HoldWatchTest, BeforeAMotionWhatIsExceededNowHoldsAtOnce) {
  EXPECT_EQ(at(0, 20.4, HoldWatch::Look::before_motion), Phase::clear);
  EXPECT_EQ(at(1, 20.6, HoldWatch::Look::before_motion), Phase::holding);
}

TEST_F(HoldWatchTest, NoFreshValueIsAsOneBeyondTheLimit) {
  at(-1, 20);
  at(0, std::nullopt);
  EXPECT_EQ(at(60, std::nullopt), Phase::holding);
  EXPECT_THAT(watch_.sentence(), HasSubstr("t12_degC has no fresh value"));
  EXPECT_EQ(at(61, 20), Phase::holding);
  EXPECT_EQ(at(661, 20), Phase::clear);
}

TEST_F(HoldWatchTest, OnlyMeasuredValuesDoWhatCannotBeTakenBack) {
  const auto is_certain = [this](double s) {
    return watch_.is_measured_beyond(kBegin + nanoseconds_from_s(s));
  };
  at(0, 20);
  at(1, std::nullopt);
  EXPECT_EQ(at(100, std::nullopt), Phase::holding);
  EXPECT_FALSE(is_certain(100)) << "nobody knows whether the limit is exceeded";
  EXPECT_EQ(at(101, 21), Phase::holding);
  EXPECT_FALSE(is_certain(101)) << "measured for less than for_s";
  at(140, std::nullopt);
  at(161, 21);
  EXPECT_TRUE(is_certain(161));
  at(162, std::nullopt);
  EXPECT_FALSE(is_certain(162));
  EXPECT_EQ(at(163, 20.4), Phase::holding);
  EXPECT_FALSE(is_certain(163)) << "it holds until it has settled, and is within its limit";
}

TEST_F(HoldWatchTest, TheFirstValueEverNeedsNoSettling) {
  EXPECT_EQ(at(0, std::nullopt, HoldWatch::Look::before_motion), Phase::holding);
  EXPECT_EQ(at(5, 20), Phase::clear);
}

TEST_F(HoldWatchTest, SaysWhatWasExceededFirstAndHowFarTheEndIs) {
  at(0, 20.62);
  at(60, 21.5);
  EXPECT_EQ(watch_.sentence(), "t12_degC is 20.62, limit 20.5 (hold room)");
  EXPECT_EQ(watch_.since(), kBegin);
  at(100, 20.1);
  EXPECT_EQ(watch_.outlook(kBegin + nanoseconds_from_s(140)),
            "t12_degC is 20.1, within its limits for 40 of 600 s");
}

}  // namespace
}  // namespace driftwise::application
