// What takes longer than deploy/test.sh has: one data set for every cause on three axes.

#include <gtest/gtest.h>

#include "tests/hidden_effects/shapes/counted_cases.h"

namespace driftwise::hidden {
namespace {

TEST(HiddenEffectsLong, AreNamedOrInTheSetOnThreeAxes) {
  const auto sum =
      counted({.kind = "single", .robot = "micro", .chi2 = {150}, .sets = 1, .seed = 601});
  EXPECT_GE(sum.in_set.high(), 0.98) << sum.in_set.hits << " of " << sum.in_set.sets;
}

}  // namespace
}  // namespace driftwise::hidden
