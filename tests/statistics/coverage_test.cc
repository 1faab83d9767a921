// The fast part of the coverage claim: the whole is `coverage --campaigns 500`
// (docs/uncertainty.md).

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/statistics/coverage_run.h"
#include "tests/statistics/linear_axis_case.h"
#include "tests/statistics/micro_nano_case.h"

namespace driftwise::statistics {
namespace {

TEST(ClopperPearson, IsTheTabulatedInterval) {
  // R: binom.test(95, 100)$conf.int
  const auto interval = clopper_pearson(95, 100);
  EXPECT_NEAR(interval.low, 0.8871651, 1e-6);
  EXPECT_NEAR(interval.high, 0.9835681, 1e-6);
  EXPECT_EQ(clopper_pearson(0, 10).low, 0);
  EXPECT_EQ(clopper_pearson(10, 10).high, 1);
}

TEST(CoverageCount, IsWiderByCampaignWhereCampaignsDiffer) {
  CoverageCount alike, apart;
  for (int i = 0; i < 40; ++i) {
    alike.add_campaign(95, 100);
    apart.add_campaign(i % 4 == 0 ? 80 : 100, 100);
  }
  EXPECT_DOUBLE_EQ(alike.rate(), apart.rate());
  const auto width = [](const Interval& interval) { return interval.high - interval.low; };
  EXPECT_GT(width(apart.clustered()), 2 * width(apart.per_target()));
  EXPECT_LT(width(alike.clustered()), 1.1 * width(alike.per_target()));
}

TEST(CoverageCount, ResamplesWholeCampaigns) {
  CoverageCount alike, apart;
  for (int i = 0; i < 40; ++i) {
    alike.add_campaign(95, 100);
    apart.add_campaign(i % 4 == 0 ? 80 : 100, 100);
  }
  EXPECT_DOUBLE_EQ(alike.resampled().low, 0.95);
  EXPECT_DOUBLE_EQ(alike.resampled().high, 0.95);
  // A mean of 40 campaigns, each 80 or 100 %: its standard deviation is 8.66 / 40^(1/2) = 1.37 %.
  EXPECT_NEAR(apart.resampled().low, 0.95 - 1.96 * 0.0137, 0.004);
  EXPECT_NEAR(apart.resampled().high, 0.95 + 1.96 * 0.0137, 0.004);
}

TEST(CoverageByLead, HasEveryTargetOfAnOutputOnce) {
  const auto outputs = run_coverage(linear_axis_case, 1, 2, 1, [](int, const auto&) {});
  for (const auto& output : outputs) {
    std::int64_t targets = 0;
    for (const auto& lead : output.by_lead) targets += lead.inside.targets();
    EXPECT_EQ(targets, output.inside.targets());
  }
  EXPECT_GT(outputs.back().by_lead[0].inside.targets(), 0);
  EXPECT_EQ(outputs.back().by_lead.back().inside.targets(), 0);  // a campaign of 3.8 h
}

TEST(Coverage, OfTheExpandedUncertaintyIs93To97PercentOnTheMicroNano) {
  constexpr int kCampaigns = 40;
  const auto outputs = run_coverage(micro_nano_case, 1, kCampaigns, 1, [](int, const auto&) {});
  std::printf("%s", coverage_table(outputs).c_str());
  const auto interval = outputs.back().inside.clustered();  // of all coordinates
  EXPECT_LE(interval.low, 0.97);
  EXPECT_GE(interval.high, 0.93);
}

}  // namespace
}  // namespace driftwise::statistics
