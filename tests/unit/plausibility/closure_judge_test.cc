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

TEST_F(Closures, WhatTheTemperaturesExplainIsGood) {
  judge.begin(at_s(0), {});
  ExpectedClosure expected;
  expected.lengths_nm = {550};
  expected.by = "model 3";
  expected.warming_k = 0.2;
  const auto verdict = judge.judge({at_s(60), {612}, {}, {}}, expected);
  EXPECT_TRUE(verdict.good);
  EXPECT_TRUE(verdict.explained);
  EXPECT_EQ(verdict.sentence,
            "x moved by +612 nm (limit 360), of which +550 nm is expected from +0.20 K by model 3");
  EXPECT_NEAR(verdict.coordinates.at(0).unexplained(), 62, 1e-9);
}

TEST_F(Closures, AnExpectationThatDoesNotExplainItChangesNothing) {
  judge.begin(at_s(0), {});
  ExpectedClosure expected;
  expected.lengths_nm = {-550};
  expected.by = "model 3";
  EXPECT_FALSE(judge.judge({at_s(60), {612}, {}, {}}, expected).good);
}

TEST_F(Closures, ASideIsComparedWithItself) {
  judge.begin(at_s(0), {}, "-");
  const Closure here{at_s(60), {900}, {}, {}, "+"}, there{at_s(61), {10}, {}, {}, "-"};
  const auto first = judge.judge(here);
  EXPECT_FALSE(first.good);
  EXPECT_TRUE(first.other_side);
  EXPECT_TRUE(judge.judge(there).good);
  judge.take_play(here, there);
  judge.take(here);
  EXPECT_TRUE(judge.judge({at_s(120), {905}, {}, {}, "+"}).good);
  EXPECT_TRUE(judge.judge({at_s(180), {5}, {}, {}, "-"}).good);
  EXPECT_FALSE(judge.judge({at_s(240), {1700}, {}, {}, "+"}).good);
  EXPECT_NEAR(judge.play("+", 0), 890, 1e-9);
}

TEST_F(Closures, APlayThatIsKnownCountsInTheNextDatum) {
  judge.begin(at_s(0), {}, "-");
  judge.take_play({at_s(60), {900}, {}, {}, "+"}, {at_s(60), {0}, {}, {}, "-"});
  judge.begin(at_s(100), {}, "-");
  const auto verdict = judge.judge({at_s(160), {905}, {}, {}, "+"});
  EXPECT_TRUE(verdict.good);
  EXPECT_FALSE(verdict.other_side);
  EXPECT_NEAR(verdict.coordinates.at(0).play, 900, 1e-9);
  EXPECT_NEAR(verdict.coordinates.at(0).found, 5, 1e-9);
}

TEST_F(Closures, ACoordinateHasALimitOfItsOwn) {
  ClosureRules rules;
  rules.limits.push_back({"x_mm", 50});
  ClosureJudge strict(description, rules);
  strict.begin(at_s(0), {});
  EXPECT_FALSE(strict.judge({at_s(1), {60}, {}, {}}).good);
}

}  // namespace
}  // namespace driftwise::plausibility
