// The check standard on the simulated linear axis, whose physics the model does not know: a robot
// that is as it was, and one whose scale has changed.

#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cstdio>

#include "drivers/simulated/plant/file/make_plant.h"
#include "server/diagnosis/check/check_standard.h"
#include "server/formats/formula/formula.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::diagnosis {
namespace {

namespace support = testing_support;

std::string thermometer(std::size_t i) { return (i < 9 ? "t0" : "t") + std::to_string(i + 1); }

RunToCheck measure(std::uint64_t seed, int passes, const std::vector<std::string>& overrides = {}) {
  constexpr simulated::TimeNs kEpoch = 1'600'000'000'000'000'000;
  const auto plant =
      simulated::make_plant(support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR),
                            {.seed = seed, .overrides = overrides, .epoch_ns = kEpoch});
  support::CampaignOptions options;
  options.passes = passes;
  const auto campaign = support::run_plant_campaign(*plant, kEpoch, options);
  RunToCheck run;
  run.run = RunId{static_cast<std::int64_t>(seed)};
  auto& data = run.data;
  data.rows = campaign.rows.size();
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t i = 0; i < 10; ++i) data.columns.push_back({{thermometer(i), "degC"}, {}});
  for (const auto& row : campaign.rows) {
    data.time_s.push_back(row.time_s);
    data.set.push_back(row.calibration ? PointSet::calibration : PointSet::validation);
    data.columns[0].values.push_back(row.q1_mm);
    data.columns[1].values.push_back(row.x_mm);
    for (std::size_t i = 0; i < 10; ++i) data.columns[2 + i].values.push_back(row.t_degc[i]);
  }
  // The first point is the visit of the zero right after the zeroing.
  const auto& first = campaign.rows.front();
  run.zeros.push_back({{"q1_mm", first.q1_mm - first.x_mm}});
  for (std::size_t i = 0; i < 10; ++i)
    run.zeros.front().push_back({thermometer(i) + "_degC", first.t_degc[i]});
  return run;
}

TEST(CheckOnPlant, LeavesTheUnchangedRobotAloneAndSeesAChangedScale) {
  constexpr double kPromise = 0.05;  // false alarms per run, at most
  constexpr int kRobots = 8, kRuns = 3;
  int runs = 0, alarms = 0, seen = 0;
  for (std::uint64_t robot = 1; robot <= kRobots; ++robot) {
    const auto model = formats::fit_formula(measure(robot, 56).data, "q1 ~ x + x^2 + t05..t10", {});
    ASSERT_TRUE(model) << model.error().message;
    std::vector<RunToCheck> later;
    for (std::uint64_t k = 1; k <= kRuns; ++k) later.push_back(measure(1000 * k + robot, 6));
    const auto report = check_model(*model, later);
    for (const auto& point : report.outputs[0].points) {
      ASSERT_TRUE(point.judged) << point.why_not;
      ++runs;
      alarms += point.out_of_control.empty() ? 0 : 1;
      std::printf("robot %d: bias %+6.1f (%.1f) nm, sd %5.1f (%.1f) nm%s\n",
                  static_cast<int>(robot), point.bias, *point.bias_limit, point.sd, point.sd_limit,
                  point.out_of_control.empty() ? "" : "  out of control");
    }
    const auto changed = measure(9000 + robot, 6, {"axis.scale_error_ppm=30"});
    seen += check_model(*model, std::vector{changed}).verdict == CheckVerdict::recalibrate ? 1 : 0;
  }
  using Binomial = boost::math::binomial_distribution<>;
  const double low = alarms == 0 ? 0 : Binomial::find_lower_bound_on_p(runs, alarms, 0.05);
  const double high = Binomial::find_upper_bound_on_p(runs, alarms, 0.05);
  std::printf(
      "%d alarms in %d runs of unchanged robots (90 %% interval %.1f to %.1f %%); a scale "
      "27 ppm longer seen in %d of %d\n",
      alarms, runs, 100 * low, 100 * high, seen, kRobots);
  EXPECT_LE(low, kPromise);
  EXPECT_EQ(seen, kRobots);
}

}  // namespace
}  // namespace driftwise::diagnosis
