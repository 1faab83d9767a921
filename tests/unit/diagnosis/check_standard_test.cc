// The check standard on data whose truth is written down here: how often it cries wolf, and what it
// sees.

#include "server/diagnosis/check/check_standard.h"

#include <gmock/gmock.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <cstdio>
#include <random>

#include "server/core/data/row_marks.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// A robot with autocorrelated noise in a room that warms: q = a x + b x^2 + c t01 + d t02.
struct Robot {
  double scale = 1.0001, bend = 2e-5, t01_mm_per_k = 4e-4, t02_mm_per_k = -2e-4;
  double noise_nm = 10, lag1 = 0.5;

  double f(double x, double t01, double t02) const {
    return scale * x + bend * x * x + t01_mm_per_k * (t01 - 21) + t02_mm_per_k * (t02 - 21);
  }
};

RunToCheck measure(const Robot& robot, std::int64_t run, int lines, std::mt19937& random) {
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> phase(0, 6.28);
  const double p1 = phase(random), p2 = phase(random);
  const auto t01 = [&](double s) { return 21 + 0.4 * std::sin(s / 3000 + p1); };
  const auto t02 = [&](double s) { return 21 + 0.3 * std::sin(s / 1700 + p2); };
  double ar = robot.noise_nm * gauss(random);
  const auto noise_mm = [&] {
    ar = robot.lag1 * ar + std::sqrt(1 - robot.lag1 * robot.lag1) * robot.noise_nm * gauss(random);
    return ar * 1e-6;
  };
  RunToCheck out;
  out.run = RunId{run};
  const double q_zero = 1e-4 * gauss(random);  // where this homing put the scale
  out.zeros = {{{"q1_mm", q_zero + noise_mm()}, {"t01_degC", t01(0)}, {"t02_degC", t02(0)}}};
  Dataset& data = out.data;
  data.columns = {
      {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}, {{"t02", "degC"}, {}}};
  for (int i = 0; i < 17 * lines; ++i) {
    const double s = 30 + 14.3 * i, x = -4 + 0.5 * (i % 17) + 2e-5 * gauss(random);
    data.time_s.push_back(s);
    data.columns[0].values.push_back(q_zero + robot.f(x, t01(s), t02(s)) -
                                     robot.f(0, t01(0), t02(0)) + noise_mm());
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(t01(s));
    data.columns[3].values.push_back(t02(s));
    ++data.rows;
  }
  return out;
}

calibration::Model learn(const Robot& robot, std::mt19937& random, int lines = 40) {
  const auto model =
      formats::fit_formula(measure(robot, 1, lines, random).data, "q1 ~ x + x^2 + T", {});
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

CheckReport check(const calibration::Model& model, const Robot& robot, int runs,
                  std::mt19937& random) {
  std::vector<RunToCheck> later;
  for (int k = 0; k < runs; ++k) later.push_back(measure(robot, 2 + k, 4, random));
  return check_model(model, later);
}

TEST(CheckStandard, KnowsTheErrorOfEveryPoint) {
  std::mt19937 random(3);
  Robot quiet;
  quiet.noise_nm = 1e-3;
  const auto model = learn(quiet, random);
  Robot longer = quiet;
  longer.t01_mm_per_k += 1e-4;  // 100 nm per K that the model does not know
  const auto run = measure(longer, 2, 4, random);
  const auto errors = run_errors(model.outputs[0], model.lineage.rows_calibration, run);
  ASSERT_TRUE(errors) << errors.error().message;
  ASSERT_TRUE(errors->anchored);
  for (std::size_t i = 0; i < run.data.rows; ++i) {
    const double warming = run.data.columns[2].values[i] - run.zeros[0][1].value;
    EXPECT_NEAR(errors->values[i], 100 * warming, 0.5);
  }
}

TEST(CheckStandard, SaysInControlOfARobotThatIsAsItWas) {
  std::mt19937 random(1);
  const Robot robot;
  const auto report = check(learn(robot, random), robot, 5, random);
  EXPECT_EQ(report.verdict, CheckVerdict::in_control);
  EXPECT_THAT(report.reasons, IsEmpty());
  ASSERT_EQ(report.outputs[0].points.size(), 5u);
  EXPECT_NEAR(report.outputs[0].reference.sd, 10, 2);
  for (const auto& point : report.outputs[0].points) EXPECT_NEAR(point.u90, 1.645 * 10, 6);
}

// A changed scale goes with x, a slipped zero with nothing, a warmer arm with its thermometer.
TEST(CheckStandard, SaysRecalibrateNowAndWhatTheErrorGoesWith) {
  std::mt19937 random(1);
  const Robot robot;
  const auto model = learn(robot, random);
  Robot stretched = robot;
  stretched.scale += 30e-6;  // 120 nm at 4 mm
  const auto scale = check(model, stretched, 1, random);
  EXPECT_EQ(scale.verdict, CheckVerdict::recalibrate);
  ASSERT_FALSE(scale.reasons.empty());
  EXPECT_THAT(scale.reasons[0], HasSubstr("run 2: q1's error spreads by"));
  EXPECT_THAT(scale.reasons[0], HasSubstr("(x explains"));

  auto run = measure(robot, 3, 4, random);
  for (auto& q : run.data.columns[0].values) q += 200e-6;
  const auto slipped = check_model(model, std::vector{run});
  EXPECT_EQ(slipped.verdict, CheckVerdict::recalibrate);
  EXPECT_THAT(slipped.reasons.at(0), HasSubstr("on average"));
}

TEST(CheckStandard, SeesOverSeveralRunsWhatOneDoesNotShow) {
  const Robot robot;
  Robot worn = robot;
  worn.noise_nm = 14;  // 40 % more
  int seen_at_once = 0, seen = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const auto model = learn(robot, random, 120);
    seen_at_once += check(model, worn, 1, random).verdict == CheckVerdict::recalibrate ? 1 : 0;
    seen += check(model, worn, 12, random).verdict == CheckVerdict::recalibrate ? 1 : 0;
  }
  std::printf("noise 1.4 times as large: seen after one run in %d of 40, after twelve in %d\n",
              seen_at_once, seen);
  EXPECT_GT(seen, seen_at_once);
}

// What all is for: a robot that is as it was must be left alone. Per run judged; five runs after
// each model, noise from white to strongly correlated.
TEST(CheckStandard, KnowsHowManyBlocksTheAccuracyOfTheModelRestsOn) {
  // An interval by t over few blocks is wide for two reasons. t alone: 2.920 over three blocks,
  // 1.833 over ten (quantile 0.95 with 2 and 9 degrees of freedom, any table).
  std::mt19937 random(5);
  const Robot robot;
  auto model = learn(robot, random);
  auto& accuracy = model.outputs[0].accuracy;
  accuracy.a90_blocks_high = *accuracy.a90_blocks * 1.5;
  const auto dof = [&](std::optional<double> blocks) {
    accuracy.block_count = blocks;
    return check(model, robot, 2, random).outputs[0].reference.dof;
  };
  EXPECT_NEAR(dof(10), 2 / std::pow(2 * std::log(1.5) / 1.833, 2), 0.01);
  EXPECT_NEAR(dof(3), 2 / std::pow(2 * std::log(1.5) / 2.920, 2), 0.01);
  EXPECT_EQ(dof(std::nullopt), dof(10)) << "a model of before";
}

TEST(CheckStandard, CriesWolfRarely) {
  constexpr double kPromise = 0.02;
  for (const double lag1 : {0.0, 0.5, 0.8}) {
    Robot robot;
    robot.lag1 = lag1;
    int runs = 0, alarms = 0;
    for (unsigned seed = 1; seed <= 150; ++seed) {
      std::mt19937 random(seed);
      const auto report = check(learn(robot, random), robot, 5, random);
      for (const auto& point : report.outputs[0].points) {
        runs += point.judged ? 1 : 0;
        alarms += point.out_of_control.empty() ? 0 : 1;
      }
    }
    using Binomial = boost::math::binomial_distribution<>;
    const double low = alarms == 0 ? 0 : Binomial::find_lower_bound_on_p(runs, alarms, 0.05);
    const double high = Binomial::find_upper_bound_on_p(runs, alarms, 0.05);
    std::printf(
        "autocorrelation %.1f: %d alarms in %d runs (%.2f %%, 90 %% interval %.2f to %.2f %%)\n",
        lag1, alarms, runs, 100.0 * alarms / runs, 100 * low, 100 * high);
    EXPECT_EQ(runs, 750) << lag1;
    EXPECT_LE(low, kPromise) << "autocorrelation " << lag1;
  }
}

TEST(CheckStandard, JudgesTheSpreadOnlyWhereTheZeroIsNotKnown) {
  std::mt19937 random(1);
  const Robot robot;
  const auto model = learn(robot, random);
  auto run = measure(robot, 2, 4, random);
  for (auto& q : run.data.columns[0].values) q += 1e-3;
  run.zeros.clear();
  const auto report = check_model(model, std::vector{run});
  EXPECT_EQ(report.verdict, CheckVerdict::in_control);
  EXPECT_FALSE(report.outputs[0].points[0].bias_limit);
}

// Every channel of a run in another unit: the same measurement.
RunToCheck in_other_units(RunToCheck run) {
  run.zeros.clear();
  for (auto& column : run.data.columns) {
    const bool temperature = column.channel.unit == "degC";
    column.channel.unit = temperature ? "K" : "um";
    for (double& value : column.values) value = temperature ? value + 273.15 : value * 1e3;
  }
  return run;
}

TEST(CheckStandard, JudgesAModelInOtherUnitsAsTheSameModelInThoseOfTheRun) {
  for (const auto* formula : {"q1 ~ x + x^2 + T", "q1 ~ x + x^2 + lag(t01, 60 s) + t02"}) {
    std::mt19937 random(1);
    const Robot robot;
    const auto rows = measure(robot, 1, 40, random);
    const auto own = formats::fit_formula(rows.data, formula, {});
    const auto foreign = formats::fit_formula(in_other_units(rows).data, formula, {});
    ASSERT_TRUE(own && foreign) << formula;
    std::vector<RunToCheck> later = {measure(robot, 2, 4, random), measure(robot, 3, 4, random)};
    for (auto& run : later) {
      run.zero_times_s = {0};
      for (int i = 600; i > 0; --i)
        run.before.push_back({-0.5 * i, {{"t01_degC", run.zeros[0][1].value}}});
    }
    const auto expected = check_model(*own, later).outputs[0];
    const auto report = check_model(*foreign, later);
    EXPECT_EQ(report.verdict, CheckVerdict::in_control) << formula;
    for (std::size_t i = 0; i < later.size(); ++i) {
      EXPECT_TRUE(report.outputs[0].points[i].bias_limit) << "its zero is known";
      EXPECT_NEAR(report.outputs[0].points[i].bias, expected.points[i].bias, 0.01);
      EXPECT_NEAR(report.outputs[0].points[i].sd, expected.points[i].sd, 0.01);
    }
  }
}

TEST(CheckStandard, LeavesARunOutWhoseUnitIsOfAnotherKind) {
  std::mt19937 random(1);
  const Robot robot;
  const auto model = learn(robot, random);
  auto run = measure(robot, 2, 4, random);
  run.data.columns[2].channel.unit = "N";
  const auto report = check_model(model, std::vector{run});
  EXPECT_EQ(report.verdict, CheckVerdict::not_judged);
  EXPECT_THAT(report.outputs[0].points[0].why_not, HasSubstr("t01 in degC, found it in N"));
}

TEST(CheckStandard, LeavesExcludedRowsAndRunsItCannotJudgeOut) {
  std::mt19937 random(1);
  const Robot robot;
  const auto model = learn(robot, random);
  auto run = measure(robot, 2, 4, random);
  run.data.excluded.assign(run.data.rows, 0);
  run.data.excluded[7] = 1;
  run.data.excluded[8] = kPassageRow;  // nobody kept it out
  run.data.columns[0].values[7] += 1;
  auto blind = measure(robot, 3, 4, random);
  blind.data.columns.pop_back();
  auto short_run = measure(robot, 4, 4, random);
  for (auto& q : short_run.data.columns[0].values) q = kMissing;
  const auto report = check_model(model, std::vector{run, blind, short_run});
  EXPECT_EQ(report.verdict, CheckVerdict::in_control);  // by run 2
  const auto& points = report.outputs[0].points;
  EXPECT_EQ(points[0].rows, 66);
  EXPECT_EQ(points[0].excluded, 1);
  EXPECT_FALSE(points[1].judged);
  EXPECT_THAT(points[1].why_not, HasSubstr("t02"));
  EXPECT_FALSE(points[2].judged);
  EXPECT_EQ(check_model(model, {}).verdict, CheckVerdict::not_judged);
}

}  // namespace
}  // namespace driftwise::diagnosis
