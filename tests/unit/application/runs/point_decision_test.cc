#include "server/application/motion/point_decision.h"

#include <gtest/gtest.h>

#include <vector>

namespace driftwise::application {
namespace {

RunRules rules(int rereads, int reapproaches, int requeues) {
  RunRules r;
  r.max_rereads = rereads;
  r.max_reapproaches = reapproaches;
  r.max_requeues = requeues;
  return r;
}

struct Case {
  const char* name;
  Trouble trouble;
  AttemptTally tally;
  Verdict verdict;
};
class Decide : public testing::TestWithParam<Case> {};
TEST_P(Decide, FollowsTheBudgets) {
  EXPECT_EQ(decide(GetParam().trouble, GetParam().tally, rules(2, 1, 1)), GetParam().verdict);
}
INSTANTIATE_TEST_SUITE_P(
    Table, Decide,
    testing::Values(
        Case{"AcceptsWithoutTrouble", Trouble::none, {2, 1, 1}, Verdict::accepted},
        Case{"RereadsFirst", Trouble::spread, {0, 0, 0}, Verdict::reread},
        Case{"RereadsWithinBudget", Trouble::spread, {1, 0, 0}, Verdict::reread},
        Case{"ReapproachesWhenRereadsAreUsedUp", Trouble::spread, {2, 0, 0}, Verdict::reapproach},
        Case{"RequeuesWhenReapproachesAreUsedUp", Trouble::spread, {2, 1, 0}, Verdict::requeued},
        Case{"GivesUpWhenAllIsUsedUp", Trouble::spread, {2, 1, 1}, Verdict::given_up},
        Case{"DoesNotRereadAnAxisThatMoves", Trouble::not_settled, {0, 0, 0}, Verdict::reapproach},
        Case{"RequeuesAnAxisThatNeverSettles", Trouble::not_settled, {0, 1, 0}, Verdict::requeued},
        Case{"GivesUpAnAxisThatNeverSettles", Trouble::not_settled, {0, 1, 1}, Verdict::given_up}),
    [](const auto& row) { return std::string(row.param.name); });

// Every point ends within (1 + rereads) (1 + reapproaches) (1 + requeues) attempts, whatever the
// budgets.
TEST(Decide, EndsWithinTheProductOfTheBudgets) {
  for (int rereads = 0; rereads < 4; ++rereads)
    for (int reapproaches = 0; reapproaches < 3; ++reapproaches)
      for (int requeues = 0; requeues < 3; ++requeues) {
        const auto r = rules(rereads, reapproaches, requeues);
        int attempts = 0;
        for (int visit = 0;; ++visit) {
          AttemptTally tally{0, 0, visit};
          Verdict verdict;
          do {
            verdict = decide(Trouble::spread, tally, r);
            tally = after(tally, verdict);
            ++attempts;
          } while (verdict == Verdict::reread || verdict == Verdict::reapproach);
          if (verdict == Verdict::given_up) break;
          ASSERT_EQ(verdict, Verdict::requeued);
        }
        EXPECT_EQ(attempts, (1 + rereads) * (1 + reapproaches) * (1 + requeues));
      }
}

TEST(SpreadNm, IsTheSampleStandardDeviation) {
  // 2, 4, 4, 4, 5, 5, 7, 9: variance 32 / 7 with n - 1. Far from zero, so that cancellation would
  // show.
  std::vector<double> mm;
  for (const double nm : {2, 4, 4, 4, 5, 5, 7, 9}) mm.push_back(4.0 + nm * 1e-6);
  EXPECT_NEAR(spread_nm(mm), std::sqrt(32.0 / 7.0), 1e-6);  // 4 mm in a double resolve 1e-9 nm
}

TEST(SpreadNm, OfOneReadingIsUnknown) {
  EXPECT_TRUE(is_missing(spread_nm(std::vector<double>{1.0})));
}

TEST(SpreadSentence, SaysFoundAndLimit) {
  EXPECT_EQ(spread_sentence(7.32, 4, 5), "spread 7.3 nm of 4 readings, limit 5 nm");
}

}  // namespace
}  // namespace driftwise::application
