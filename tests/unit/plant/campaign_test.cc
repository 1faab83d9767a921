// The published campaign on the plant: does a fit of thermometers find what the physics does?
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "drivers/simulated/plant/file/make_plant.h"
#include "tests/unit/plant/least_squares.h"

namespace driftwise::testing_support {
namespace {

struct Table {
  FitFigures geometry, ten, six, first_300, oracle;
  int rejected = 0;
};

Table table_of(std::uint64_t seed, const std::vector<std::string>& overrides = {}) {
  constexpr simulated::TimeNs kEpoch = 1'600'000'000'000'000'000;
  const auto plant =
      simulated::make_plant(linear_axis_plant_file(DRIFTWISE_SOURCE_DIR),
                            {.seed = seed, .overrides = overrides, .epoch_ns = kEpoch});
  const Campaign campaign = run_plant_campaign(*plant, kEpoch);
  const auto& rows = campaign.rows;
  const auto calibration = [](const CampaignRow& row) { return row.calibration; };
  const double end_of_300_s = rows[299].time_s;
  const auto early = [=](const CampaignRow& row) {
    return row.calibration && row.time_s <= end_of_300_s;
  };
  return {.geometry = fit_campaign(rows, polynomial_and_temperatures(0, -1), calibration),
          .ten = fit_campaign(rows, polynomial_and_temperatures(1, 10), calibration),
          .six = fit_campaign(rows, polynomial_and_temperatures(5, 10), calibration),
          .first_300 = fit_campaign(rows, polynomial_and_temperatures(1, 10), early),
          .oracle = fit_campaign(rows, oracle_columns(), calibration),
          .rejected = campaign.rejected_groups};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

TEST(PlantCampaign, TenSensorsComeWithin15PercentOfALeastSquaresThatKnowsTheTruth) {
  std::printf("S90 on validation, nm   published: geometry 206, 300 points 40, six 15, ten 9\n");
  std::printf("seed  geometry  300 points (p90)    six    ten  oracle  ten/oracle  rejected\n");
  std::vector<double> geometry, early, six, ten, oracle, ratio;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Table t = table_of(seed);
    geometry.push_back(t.geometry.u90_nm);
    early.push_back(t.first_300.u90_nm);
    six.push_back(t.six.u90_nm);
    ten.push_back(t.ten.u90_nm);
    oracle.push_back(t.oracle.u90_nm);
    ratio.push_back(t.ten.u90_nm / t.oracle.u90_nm);
    std::printf("%4d  %8.1f  %10.1f (%5.1f)  %5.2f  %5.2f  %6.2f  %10.3f  %8d\n",
                static_cast<int>(seed), geometry.back(), early.back(), t.first_300.p90_nm,
                six.back(), ten.back(), oracle.back(), ratio.back(), t.rejected);
  }
  std::printf("med.  %8.1f  %10.1f          %5.2f  %5.2f  %6.2f  %10.3f\n", median(geometry),
              median(early), median(six), median(ten), median(oracle), median(ratio));
  EXPECT_THAT(ratio, testing::Each(testing::AllOf(testing::Gt(0.85), testing::Lt(1.15))));
  EXPECT_GT(median(geometry), median(early));
  EXPECT_GT(median(early), median(six));
  EXPECT_GT(median(six), median(ten));
}

}  // namespace
}  // namespace driftwise::testing_support
