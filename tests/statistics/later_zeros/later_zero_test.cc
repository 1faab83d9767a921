// Targets after a zero outside the fitted domain. The whole is `later_zeros` (docs/uncertainty.md).

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/statistics/later_zeros/later_zero_case.h"

namespace driftwise::statistics {
namespace {

constexpr std::uint64_t kFirstAxis = 90001;
constexpr int kAxes = 8;

TEST(LaterZero, CountsInTheUncertaintyWhereItWasTakenOutside) {
  LaterZeroCount count;
  for (int i = 0; i < kAxes; ++i) count.add(later_zeros(kFirstAxis + static_cast<unsigned>(i)));
  std::fputs(count.table().c_str(), stdout);
  int targets = 0, hits = 0, hits_of_pose = 0;
  for (const auto& one : count.classes()) {
    const bool outside = one.from > 0;
    EXPECT_EQ(one.flagged, outside ? one.targets : 0);
    if (!outside) continue;
    targets += one.targets;
    hits += one.hits;
    hits_of_pose += one.hits_of_pose;
  }
  ASSERT_GT(targets, 200);
  EXPECT_GT(hits, 0.95 * targets);
  EXPECT_LT(hits_of_pose, 0.95 * targets) << "the conditions of the pose alone say too little";
}

}  // namespace
}  // namespace driftwise::statistics
