// Targets after a later zero, outside the fitted domain or within. The whole is `later_zeros`
// (docs/uncertainty.md).

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/statistics/later_zeros/later_zero_case.h"

namespace driftwise::statistics {
namespace {

constexpr std::uint64_t kFirstAxis = 90001;
constexpr int kAxes = 8;

TEST(LaterZero, CountsInTheUncertaintyWhereItWasTakenOutside) {
  LaterZeroCount count;
  for (int i = 0; i < kAxes; ++i) {
    const auto zeros = later_zeros(kFirstAxis + static_cast<unsigned>(i));
    // All poses are inside, so that the zero's excess is the largest.
    for (const auto& targets : zeros)
      for (const auto& target : targets)
        EXPECT_NEAR(target.u_nm / target.u_of_pose_nm, std::pow(1 + target.zero_excess, 2), 1e-9);
    count.add(zeros);
  }
  std::fputs(count.table().c_str(), stdout);
  int targets = 0, hits = 0;
  for (const auto& one : count.classes()) {
    const bool outside = one.from > 0;
    EXPECT_EQ(one.flagged, outside ? one.targets : 0);
    if (!outside) continue;
    targets += one.targets;
    hits += one.hits;
  }
  ASSERT_GT(targets, 200);
  EXPECT_GT(hits, 0.95 * targets);
}

// A later zero shows the slow noise of the measuring device that the coefficients took up. With one
// correlation length for all noise 84 % of these targets were within 2u.
TEST(LaterZero, WithinTheDomainIsHeldByTheStatedUncertainty) {
  LaterZeroCount count;
  for (int i = 0; i < 2 * kAxes; ++i)
    count.add(later_zeros(kFirstAxis + static_cast<unsigned>(i),
                          {.stays_within = true, .select = calibration::Select::all}));
  std::fputs(count.table().c_str(), stdout);
  const auto& inside = count.classes().front();
  ASSERT_GT(inside.targets, 200);
  EXPECT_EQ(inside.flagged, 0);
  EXPECT_GT(inside.rate(), 0.9);
  EXPECT_GE(inside.by_machine.clustered().high, 0.93);
}

}  // namespace
}  // namespace driftwise::statistics
