// The fast part of docs/diagnosis-plants.md: one plant each of the causes that are named there in
// every seed, and the plants that hide nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/hidden_effects/plants/plant_cases.h"

namespace driftwise::hidden {
namespace {

class HiddenInAPlant : public testing::TestWithParam<const char*> {};

TEST_P(HiddenInAPlant, IsNamedAndNothingElseIs) {
  for (const auto& one : plant_cases()) {
    if (one.name != GetParam()) continue;
    const auto run = run_case(one, 1);
    const auto verdict = judged_by_truth(one, run, diagnosed_case(one, run.data, 49));
    EXPECT_TRUE(verdict.exact) << verdict.named;
    if (std::isfinite(verdict.u90_known)) {
      EXPECT_LE(verdict.u90_after,
                verdict.u90_known + 0.05 * (verdict.u90_before - verdict.u90_known) + 0.5)
          << "95 % of what knowing the truth gives";
    }
    return;
  }
  FAIL() << "no such case";
}

INSTANTIATE_TEST_SUITE_P(Plants, HiddenInAPlant,
                         testing::Values("axis.nothing", "axis.geometry", "axis.expansion",
                                         "axis.scale_signals", "axis.fringes", "axis.laser",
                                         "axis.lost_fringe", "axis.slip", "axis.level",
                                         "micro.nothing"),
                         [](const auto& row) {
                           std::string name = row.param;
                           name[name.find('.')] = '_';
                           return name;
                         });

}  // namespace
}  // namespace driftwise::hidden
