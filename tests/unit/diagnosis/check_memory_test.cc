// The check standard of a robot that follows its room through a lag, in a room that drifts.

#include "server/diagnosis/check/check_memory.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/diagnosis/check/check_standard.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kTau_s = 3600, kExpansion_mm_per_k = 1e-3, kReadingNoise_mm = 5e-6;

Dataset empty_table() {
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t07", "degC"}, {}}};
  return data;
}

void add_row(Dataset& data, double time_s, double temperature, double lagged,
             std::mt19937& random) {
  std::normal_distribution<double> gauss;
  const double x = -4 + 8 * std::fmod(static_cast<double>(data.rows) * 0.618, 1.0);
  data.time_s.push_back(time_s);
  data.columns[0].values.push_back(x + kExpansion_mm_per_k * lagged +
                                   kReadingNoise_mm * gauss(random));
  data.columns[1].values.push_back(x);
  data.columns[2].values.push_back(temperature);
  ++data.rows;
}

// The room begins at 20 degC where it was, and swings.
calibration::Model learn_lag(std::mt19937& random) {
  Dataset data = empty_table();
  double lagged = 20, before = 20;
  for (int i = 0; i < 600; ++i) {
    const double s = 15.0 * i, now = 20 + 0.8 * std::sin(s / 2500);
    if (i > 0) {  // exact for a straight line between the rows
      const double ramp = (now - before) * kTau_s / 15;
      lagged = now - ramp + (lagged - before + ramp) * std::exp(-15 / kTau_s);
    }
    before = now;
    add_row(data, s, now, lagged, random);
  }
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  const auto model = formats::fit_formula(data, "q1 ~ x + lag(t07, 3600 s)", options);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

// 50 minutes in a room that has risen by 0.5 K/h for 20 h: the lag is 0.5 K behind. The zero was
// taken a minute before the first row.
RunToCheck measured_in_a_rising_room(std::mt19937& random, double read_before_h) {
  constexpr double kPerSecond = 0.5 / 3600;
  const auto room = [](double s) { return 18 + kPerSecond * (s + 6 * 3600); };
  RunToCheck run{RunId{7}, empty_table(), {}};
  for (int i = 0; i < 200; ++i)
    add_row(run.data, 15.0 * i, room(15.0 * i), room(15.0 * i) - kPerSecond * kTau_s, random);
  const double zero_s = -60;
  run.zeros = {{{"q1_mm", kExpansion_mm_per_k * (room(zero_s) - kPerSecond * kTau_s)},
                {"t07_degC", room(zero_s)}}};
  run.zero_times_s = {zero_s};
  for (double s = -3600 * read_before_h; s < 0; s += 30)
    run.before.push_back({s, {{"t07_degC", room(s)}}});
  return run;
}

TEST(CheckMemory, ALagCountsAsTheReadingsBeforeTheRunHaveIt) {
  std::mt19937 random(3);
  const auto model = learn_lag(random);
  const auto report = check_model(model, std::vector{measured_in_a_rising_room(random, 10)});
  EXPECT_EQ(report.verdict, CheckVerdict::in_control) << testing::PrintToString(report.reasons);
  const auto& point = report.outputs[0].points[0];
  EXPECT_EQ(point.rows, 200);
  ASSERT_TRUE(point.bias_limit);
  EXPECT_NEAR(point.bias, 0, 3);  // the noise of the zero is 5 nm at most
  EXPECT_NEAR(point.sd, 5, 1);
}

TEST(CheckMemory, ARunWhoseRoomWasNotReadBeforeIsNotJudged) {
  std::mt19937 random(3);
  const auto model = learn_lag(random);
  for (const double read_h : {0.0, 3.0}) {
    const auto report = check_model(model, std::vector{measured_in_a_rising_room(random, read_h)});
    EXPECT_EQ(report.verdict, CheckVerdict::not_judged) << read_h;
    const auto& point = report.outputs[0].points[0];
    EXPECT_FALSE(point.judged);
    EXPECT_THAT(point.why_not, testing::HasSubstr("lag(t07, 3600 s) needs readings of 5.0 h"));
    EXPECT_THAT(point.why_not,
                testing::HasSubstr(read_h > 1 ? "begin 3.0 h before" : "before the"));
  }
}

// The zero is one minute too early for it, most rows are not.
TEST(CheckMemory, AZeroOfAnUnknownPastIsNone) {
  std::mt19937 random(3);
  const auto model = learn_lag(random);
  const auto report = check_model(model, std::vector{measured_in_a_rising_room(random, 5)});
  EXPECT_EQ(report.verdict, CheckVerdict::in_control);
  EXPECT_FALSE(report.outputs[0].points[0].bias_limit);
}

TEST(CheckMemory, AModelWithoutAMemoryIsLeftAsItIs) {
  calibration::Model model;
  calibration::OutputModel q1;
  q1.channel = {"q1", "mm"};
  q1.terms = {{{effects::Power{"x"}}}, {{effects::Call{"creep", {"q1"}, {{1, "s"}, {300, "s"}}}}}};
  model.outputs = {q1};
  EXPECT_EQ(memory_of(model).longest_tau_s, 0);
  EXPECT_EQ(with_effects_as_channels(model).outputs[0].terms, q1.terms);
}

}  // namespace
}  // namespace driftwise::diagnosis
