#include "server/application/upkeep/speed_governor.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

constexpr std::int64_t kMs = 1'000'000;
const auto kFine = nanoseconds_from_s(0.01);
const auto kLate = nanoseconds_from_s(1.5);

TEST(SpeedGovernor, HalvesWhileTheLagExceedsOneSecond) {
  SpeedGovernor g(200);
  EXPECT_EQ(g.report(kLate, 1000 * kMs), 100.0);
  EXPECT_EQ(g.report(kLate, 1050 * kMs), std::nullopt);  // the last one must show its effect first
  EXPECT_EQ(g.report(kLate, 1150 * kMs), 50.0);
}

TEST(SpeedGovernor, NeverFallsBelowRealTime) {
  SpeedGovernor g(3);
  for (int i = 1; i < 20; ++i) g.report(kLate, i * 1000 * kMs);
  EXPECT_EQ(g.present(), 1.0);
}

TEST(SpeedGovernor, RecoversSlowlyToItsNominalSpeed) {
  SpeedGovernor g(200);
  g.report(kLate, 1000 * kMs);
  EXPECT_EQ(g.report(kFine, 2000 * kMs), std::nullopt);
  EXPECT_EQ(g.report(kFine, 3100 * kMs), 125.0);
  EXPECT_EQ(g.report(kFine, 3200 * kMs), std::nullopt);
  for (int i = 4; i < 30; ++i) g.report(kFine, i * 2000 * kMs);
  EXPECT_EQ(g.present(), 200.0);
}

TEST(SpeedGovernor, DoesNotRecoverWhileTheLagIsUncomfortable) {
  SpeedGovernor g(200);
  g.report(kLate, 1000 * kMs);
  for (int i = 2; i < 100; ++i)
    EXPECT_EQ(g.report(nanoseconds_from_s(0.5), i * 1000 * kMs), std::nullopt);
}

TEST(SpeedGovernor, LeavesRealTimeAlone) {
  SpeedGovernor g(1);
  EXPECT_EQ(g.report(nanoseconds_from_s(60), 1000 * kMs), std::nullopt);
}

}  // namespace
}  // namespace driftwise::application
