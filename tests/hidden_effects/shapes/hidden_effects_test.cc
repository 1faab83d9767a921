// The fast part of hidden_effects_sweep: one data set for every cause on the linear axis, and some
// with nothing in them. Fails where a Clopper-Pearson interval excludes what is promised. Three
// axes take three times as long: hidden_effects_long_test.cc.

#include <gtest/gtest.h>

#include "tests/hidden_effects/shapes/counted_cases.h"

namespace driftwise::hidden {
namespace {

TEST(HiddenEffects, AreNamedOrInTheSetOnTheLinearAxis) {
  const auto sum = counted({.kind = "single", .chi2 = {150}, .sets = 1, .seed = 501});
  EXPECT_GE(sum.in_set.high(), 0.98) << sum.in_set.hits << " of " << sum.in_set.sets;
}

TEST(HiddenEffects, NothingHiddenNamesNothing) {
  const auto sum =
      counted({.kind = "null", .autocorrelation = {0, 0.5, 0.9}, .sets = 4, .seed = 701});
  EXPECT_LE(sum.false_name.low(), 0.01) << sum.false_name.hits << " of " << sum.false_name.sets;
}

TEST(HiddenEffects, ABrokenThermometerIsNotPhysics) {
  const auto cases = cases_of(
      {.kind = "fault", .cause = "sensor_fault", .autocorrelation = {0.3}, .sets = 1, .seed = 901});
  ASSERT_EQ(cases.size(), 2U);
  for (const auto& one : cases) {
    const auto outcome = judged(one.world, one.hidden, one.seed, 99, false);
    EXPECT_TRUE(outcome.exact) << one.key << ": " << outcome.named;
  }
}

}  // namespace
}  // namespace driftwise::hidden
