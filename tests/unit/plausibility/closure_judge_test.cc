#include "server/plausibility/closure_judge.h"

#include <gtest/gtest.h>

#include "tests/unit/plausibility/cells.h"

namespace driftwise::plausibility {
namespace {

class Closures : public testing::Test {
 protected:
  bool good(double minutes, double nm, std::optional<double> force_n = {}) {
    return judge.judge({at_s(60 * minutes), {nm}, {}, force_n}).good;
  }
  CellDescription description = cell();  // 300 nm, and 60 nm/min of the start check
  ClosureJudge judge{description};
};

TEST_F(Closures, ADriftThatTheStartAllowsIsGood) {
  judge.begin(at_s(0), {});
  for (int k = 1; k < 100; ++k) EXPECT_TRUE(good(5 * k, 290.0 * k)) << k;
}

TEST_F(Closures, AJumpIsBadAndTheLastGoodOneStaysTheBase) {
  judge.begin(at_s(0), {});
  EXPECT_TRUE(good(5, 100));
  EXPECT_FALSE(good(10, 100 + 610));
  EXPECT_EQ(judge.last_good(), at_s(300));
  EXPECT_FALSE(good(11, -100 - 610));
  EXPECT_TRUE(good(12, 120));
}

TEST_F(Closures, AnotherForceMayBendTheRobot) {
  judge.begin(at_s(0), 0.0);
  EXPECT_TRUE(good(5, 15'000, 2.3));
  EXPECT_FALSE(good(10, 0, 2.3));
}

TEST_F(Closures, AMissingLengthKeepsTheOneBefore) {
  judge.begin(at_s(0), {});
  EXPECT_TRUE(good(5, 500));
  EXPECT_TRUE(good(6, kNan));
  EXPECT_FALSE(good(7, 0));
}

TEST_F(Closures, WhatIsNoNumberIsBad) {
  judge.begin(at_s(0), {});
  EXPECT_FALSE(good(5, 1e308 * 10));
}

}  // namespace
}  // namespace driftwise::plausibility
