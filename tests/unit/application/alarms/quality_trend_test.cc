#include <gtest/gtest.h>

#include "server/application/alarms/alarm_conditions.h"

namespace driftwise::application {
namespace {

constexpr double kLimit_nm = 5;

RunProgress after(std::int64_t accepted, std::int64_t attempts, double spread_nm = 1.5) {
  RunProgress progress;
  progress.run.id = RunId{2};
  progress.run.accepted = accepted;
  progress.run.attempts = attempts;
  progress.last_spread_nm = spread_nm;
  return progress;
}

// points in one attempt each, from these on.
void measure(QualityTrend& trend, std::int64_t accepted, std::int64_t attempts, int points) {
  for (int k = 1; k <= points; ++k) trend.take(after(accepted + k, attempts + k));
}

TEST(QualityTrend, TellsOfPointsThatTakeTwoAttemptsEach) {
  QualityTrend trend;
  trend.take(after(0, 0));
  for (int k = 1; k <= 19; ++k) trend.take(after(k, 2 * k));
  EXPECT_FALSE(trend.condition(kLimit_nm));
  trend.take(after(20, 40));
  ASSERT_TRUE(trend.condition(kLimit_nm));
  EXPECT_NE(trend.condition(kLimit_nm)->message.find("took 2.0 attempts each"), std::string::npos);
  measure(trend, 20, 40, 20);
  EXPECT_FALSE(trend.condition(kLimit_nm));
}

// 30 and 31 attempts for 20 points in turn: nine alarms in 50 minutes of the two robots' cell.
TEST(QualityTrend, IsOneAlarmWhilePointsTakeAboutAsManyAttemptsAsItsLimit) {
  QualityTrend trend;
  trend.take(after(0, 0));
  int begun = 0;
  std::int64_t attempts = 0;
  for (int k = 1; k <= 400; ++k) {
    const bool before = trend.condition(kLimit_nm).has_value();
    attempts += k % 2 == 0 || k % 21 == 0 ? 2 : 1;
    trend.take(after(k, attempts));
    begun += !before && trend.condition(kLimit_nm).has_value();
  }
  EXPECT_EQ(begun, 1);
  measure(trend, 400, attempts, 20);
  EXPECT_FALSE(trend.condition(kLimit_nm));
}

TEST(QualityTrend, DoesNotCountWhatWasMeasuredBeforeTheDaemonBeganAgain) {
  QualityTrend trend;
  trend.take(after(12, 13));
  for (int k = 1; k <= 25; ++k) {
    trend.take(after(12 + k, 13 + k));
    EXPECT_FALSE(trend.condition(kLimit_nm)) << k;
  }
}

TEST(QualityTrend, TellsOfASpreadNearTheLimit) {
  QualityTrend trend;
  trend.take(after(0, 0));
  for (int k = 1; k <= 20; ++k) trend.take(after(k, k, 4.5));
  EXPECT_TRUE(trend.condition(kLimit_nm));
}

}  // namespace
}  // namespace driftwise::application
