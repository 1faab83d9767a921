// What is in no catalogue must end in "unexplained", with what it goes with, and not in the nearest
// name: a particle on the guide of the linear axis, a bump of 60 nm where it lies.

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/hidden_effects/plants/plant_cases.h"

namespace driftwise::hidden {
namespace {

const PlantCase& particle() {
  for (const auto& one : plant_cases())
    if (one.name == "axis.particle") return one;
  throw std::runtime_error("no such case");
}

class NotInTheCatalogue : public testing::TestWithParam<int> {};

TEST_P(NotInTheCatalogue, IsUnexplainedAndGoesWithThePosition) {
  const auto run = run_case(particle(), static_cast<std::uint64_t>(GetParam()));
  const auto found = diagnosed_run(particle().baseline, run.data, 49);
  const auto verdict = judged_by_truth(particle(), run, found);
  EXPECT_EQ(found.verdict, diagnosis::Verdict::unexplained) << verdict.named;
  EXPECT_TRUE(found.findings.empty()) << verdict.named;
  ASSERT_FALSE(found.left_over.empty());
  EXPECT_EQ(found.left_over.front().goes_with, "x");
}

// Nine places of calibration can be interpolated by anything; the places between them judge it.
TEST_P(NotInTheCatalogue, NeverMakesTheRowsHeldOutWorse) {
  const auto run = run_case(particle(), static_cast<std::uint64_t>(GetParam()));
  const auto found = diagnosed_run(particle().baseline, run.data, 49);
  for (const auto& output : found.outputs) {
    ASSERT_TRUE(output.u90_validation_before && output.u90_validation_after);
    EXPECT_LE(*output.u90_validation_after, 1.05 * *output.u90_validation_before);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, NotInTheCatalogue, testing::Values(1, 2));

}  // namespace
}  // namespace driftwise::hidden
