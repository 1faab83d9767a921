// Case B on ten simulated machines: the published four models, the recommended one, and how far
// that is from an oracle that knows the plant's terms. The whole: `case_b`, figures in
// docs/evidence/case-b.md.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/statistics/case_b_models.h"

namespace driftwise::statistics {
namespace {

TEST(CaseB, FullModelIsWithin15PercentOfAnOracleThatKnowsThePlantsTerms) {
  std::vector<CaseBSeed> seeds;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    seeds.push_back(case_b_seed(seed, case_b_models()));
  std::printf("%s", case_b_table(seeds, case_b_models()).c_str());
  const std::size_t recommended = case_b_models().size() - 1;
  EXPECT_LE(median_of(ratios(seeds, recommended, &CaseBSeed::terms_oracle)), 1.15);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> gain;  // of the products of force and temperatures with the pose
    for (const auto& seed : seeds)
      gain.push_back(seed.models[recommended].u90[axis] / seed.models[3].u90[axis]);
    EXPECT_LT(median_of(gain), 0.9) << axis;
  }
}

TEST(CaseB, ErrorOfRobotAndErrorOfInstrumentsAddUpToTheModels) {
  const auto campaign = case_b_campaign(11);
  const auto figures = case_b_figures(campaign, case_b_models()[3]);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(figures.u90[axis],
                std::hypot(figures.robot_u90[axis], figures.instruments_u90[axis]),
                0.15 * figures.u90[axis]);
}

}  // namespace
}  // namespace driftwise::statistics
