#include "server/indentation/contact_detector.h"

#include <gtest/gtest.h>

#include <limits>

namespace driftwise::indentation {
namespace {

using Verdict = ContactDetector::Verdict;

Eigen::MatrixXd window(double q1_nm, double q2_nm, double q3_nm) {
  Eigen::MatrixXd readings(2, 3);
  readings << q1_nm - 5, q2_nm - 5, q3_nm - 5, q1_nm + 5, q2_nm + 5, q3_nm + 5;
  return readings;
}

// Each axis holds somewhere within +-35 nm.
ContactDetector with_baseline() {
  ContactDetector detector({});
  for (int i = 0; i < 5; ++i) EXPECT_EQ(*detector.add(window(30, -28, 33)), Verdict::baseline);
  return detector;
}

TEST(ContactDetector, FindsAStepOfAllAxesInTwoConsecutiveWindows) {
  auto detector = with_baseline();
  EXPECT_EQ(*detector.add(window(30, -28, 33)), Verdict::free);
  EXPECT_EQ(*detector.add(window(-190, -248, -187)), Verdict::look_again);
  EXPECT_EQ(*detector.add(window(-190, -248, -187)), Verdict::contact);
  EXPECT_NEAR(detector.shift_nm()[1], -220, 1e-9);
}

struct Case {
  const char* name;
  double first_nm[3], second_nm[3];
};
class FreeRobot : public testing::TestWithParam<Case> {};
TEST_P(FreeRobot, IsNoContact) {
  auto detector = with_baseline();
  const auto& [name, a, b] = GetParam();
  EXPECT_NE(*detector.add(window(30 + a[0], -28 + a[1], 33 + a[2])), Verdict::contact);
  EXPECT_NE(*detector.add(window(30 + b[0], -28 + b[1], 33 + b[2])), Verdict::contact);
}
INSTANTIATE_TEST_SUITE_P(
    Table, FreeRobot,
    testing::Values(Case{"one_axis_only", {200, 0, 0}, {200, 0, 0}},
                    Case{"two_sides", {200, 200, -200}, {200, 200, -200}},
                    Case{"one_window", {300, 300, 300}, {0, 0, 0}},
                    Case{"side_changes", {300, 300, 300}, {-300, -300, -300}},
                    Case{"below_the_threshold", {124, 124, 124}, {124, 124, 124}}),
    [](const auto& row) { return std::string(row.param.name); });

ContactDetector::Verdict after(ContactDetector& detector, double q1_nm, double q2_nm,
                               double q3_nm) {
  return *detector.add(window(30 + q1_nm, -28 + q2_nm, 33 + q3_nm));
}

TEST(ContactDetector, FindsAFaintShiftThatAllAxesShareInFourConsecutiveWindows) {
  auto detector = with_baseline();
  EXPECT_NEAR(detector.faint_nm(), 30, 1e-9) << "two readings 10 nm apart: their mean has 5 nm";
  for (int i = 0; i < 3; ++i) EXPECT_EQ(after(detector, 36, 32, 39), Verdict::look_again);
  EXPECT_EQ(after(detector, 36, 32, 39), Verdict::contact);
  EXPECT_EQ(detector.side(), 1);
}

TEST(ContactDetector, TakesTheRingingOfAKnockForNoFaintShift) {
  auto detector = with_baseline();
  for (const double nm : {90.0, 60.0, -40.0, 25.0, 25.0, 25.0, 2.0, 1.0})
    EXPECT_NE(after(detector, nm, nm, nm), Verdict::contact);
  EXPECT_EQ(after(detector, 0, 0, 0), Verdict::free);
}

TEST(ContactDetector, TakesAnAxisThatLatchesElsewhereForNoFaintShift) {
  auto detector = with_baseline();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(after(detector, 60, 5, 0), Verdict::free);
}

TEST(ContactDetector, AsksMoreOfAFaintShiftWhereTheRobotIsRestless) {
  auto detector = with_baseline();
  for (int i = 0; i < 20; ++i) {
    const double nm = i % 2 == 0 ? 15 : -15;
    EXPECT_NE(after(detector, nm, nm, nm), Verdict::contact);
  }
  EXPECT_GT(detector.faint_nm(), 60);
  for (int i = 0; i < 8; ++i) EXPECT_NE(after(detector, 50, 50, 50), Verdict::contact);
}

TEST(ContactDetector, FollowsASlowDriftOfTheHoldingError) {
  auto detector = with_baseline();
  for (int i = 0; i < 200; ++i)
    EXPECT_EQ(after(detector, 0.5 * i, 0.5 * i, 0.5 * i), Verdict::free) << i;
}

TEST(ContactDetector, KeepsItsBaselineWhenOneOfItsWindowsIsKnocked) {
  ContactDetector detector({});
  for (const double knock_nm : {0.0, 0.0, 700.0, 0.0, 0.0})
    EXPECT_EQ(*detector.add(window(30 + knock_nm, -28 + knock_nm, 33 + knock_nm)),
              Verdict::baseline);
  EXPECT_EQ(*detector.add(window(30, -28, 33)), Verdict::free);
  EXPECT_NEAR(detector.shift_nm().norm(), 0, 1e-9);
}

TEST(ContactDetector, AbortsWhenAnAxisStaysBeyondTheLimit) {
  auto detector = with_baseline();
  EXPECT_EQ(*detector.add(window(1100, 0, 0)), Verdict::look_again);
  EXPECT_EQ(*detector.add(window(1100, 0, 0)), Verdict::abort);
}

TEST(ContactDetector, RefusesAWindowThatHoldsNoNumbersOrOtherAxes) {
  auto detector = with_baseline();
  EXPECT_EQ(detector.add(Eigen::MatrixXd(0, 3)).error().reason, "BAD_VALUE");
  EXPECT_EQ(detector.add(Eigen::MatrixXd::Zero(2, 2)).error().reason, "BAD_VALUE");
  EXPECT_EQ(detector.add(window(std::numeric_limits<double>::quiet_NaN(), 0, 0)).error().reason,
            "BAD_VALUE");
}

// The table begins to swing by 30 nm after the baseline: what was learnt in the quiet is no longer
// the robot's scatter.
TEST(ContactDetector, LearnsADisturbanceThatBeginsAfterTheBaseline) {
  auto detector = with_baseline();
  int free = 0;
  for (int i = 0; i < 200; ++i) {
    const double swing_nm = i % 2 == 0 ? 30 : -30;
    const auto verdict = detector.add(window(swing_nm, swing_nm, swing_nm));
    ASSERT_TRUE(verdict);
    EXPECT_NE(*verdict, ContactDetector::Verdict::contact);
    EXPECT_NE(*verdict, ContactDetector::Verdict::abort);
    free += *verdict == ContactDetector::Verdict::free ? 1 : 0;
  }
  EXPECT_GT(free, 150);
  EXPECT_GT(detector.faint_nm(), 30);
}

TEST(ContactDetector, EndsItsLooksWhereTheRobotNeverComesToRest) {
  auto detector = with_baseline();
  for (int i = 0; i + 1 < kMostLooks; ++i) {
    const double swing_nm = i % 2 == 0 ? 400 : -400;
    EXPECT_EQ(*detector.add(window(swing_nm, swing_nm, swing_nm)),
              ContactDetector::Verdict::look_again);
  }
  EXPECT_EQ(*detector.add(window(-400, -400, -400)), ContactDetector::Verdict::abort);
}

}  // namespace
}  // namespace driftwise::indentation
