// The plan of case B as the campaign helper runs it.
#include "tests/support/micro_nano_campaign.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace driftwise::testing_support {
namespace {

TEST(MicroNanoCampaign, IsThePublishedPlan) {
  const auto rows = run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, {.seed = 1, .coarse = true});
  ASSERT_EQ(rows.size(), 1056U);
  const auto count = [&](auto&& wanted) { return std::count_if(rows.begin(), rows.end(), wanted); };
  EXPECT_EQ(count([](const auto& r) { return r.calibration; }), 756);
  EXPECT_EQ(count([](const auto& r) { return r.zero; }), 3 * 36 + 2 * 25);
  EXPECT_EQ(
      count([](const auto& r) { return r.grid == 2 && !r.calibration && r.force_n == 0.768; }),
      150);
  EXPECT_EQ(rows.front().force_n, 0);
  EXPECT_EQ(rows.back().force_n, 3.842);
  EXPECT_NEAR(rows.back().time_s / 3600, 5.5, 0.1);
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end(),
                             [](const auto& a, const auto& b) { return a.time_s < b.time_s; }));
}

TEST(MicroNanoCampaign, ReadsWhatIsTrueWithinItsErrors) {
  const auto rows = run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, {.seed = 2});
  double worst_nm = 0, worst_arcsec = 0, worst_q_nm = 0;
  int noisy = 0;
  for (const auto& row : rows) {
    for (std::size_t k = 0; k < 3; ++k) {
      worst_nm = std::max(worst_nm, std::abs(row.path_mm[k] - row.true_mm[k]) * 1e6);
      worst_arcsec = std::max(worst_arcsec, std::abs(row.r_arcsec[k] - row.true_r_arcsec[k]));
      worst_q_nm = std::max(worst_q_nm, std::abs(row.q_mm[k] - row.true_q_mm[k]) * 1e6);
      if (row.path_std_nm[k] > 20) ++noisy;
    }
  }
  EXPECT_LT(worst_nm, 1500) << "Abbe: 24 arcsec at some millimetres";
  EXPECT_LT(worst_arcsec, 0.6) << "drift 0.1 arcsec, gain and roll";
  EXPECT_LT(worst_q_nm, 8) << "half a step of 5 nm and jitter";
  // "Never superior to 20 nm": but for the shocks, which the run engine reads again.
  EXPECT_LT(noisy, 60);
}

TEST(MicroNanoCampaign, IsTheSameForTheSameSeed) {
  MicroNanoOptions options{.seed = 3, .coarse = true};
  options.grids = {{false, 0.768}};
  const auto one = run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, options);
  const auto other = run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, options);
  ASSERT_EQ(one.size(), 150U);
  for (std::size_t k = 0; k < one.size(); ++k) {
    ASSERT_EQ(one[k].path_mm, other[k].path_mm);
    ASSERT_EQ(one[k].t_degc, other[k].t_degc);
  }
}

TEST(MicroNanoSession, GoesOnAfterTheGrids) {
  MicroNanoOptions options{.seed = 4, .coarse = true};
  options.grids = {{false, 0}};
  MicroNanoSession session(DRIFTWISE_SOURCE_DIR, options);
  session.run_grids();
  session.load(0.3924);
  const auto row = session.visit({1.1, 0.7, 1.9});
  EXPECT_EQ(row.force_n, 0.3924);
  EXPECT_NEAR(row.q_mm[1], 0.7, 60e-6);
  EXPECT_NEAR(row.true_force_n, 0.3924, 0.02);
}

}  // namespace
}  // namespace driftwise::testing_support
