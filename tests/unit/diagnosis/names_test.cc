// Names that are easily the wrong ones: what an instrument does, what one time constant leaves of
// two, wrong rows. An axis of 9 places, made here; nothing of the effects' code.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "server/diagnosis/diagnose.h"
#include "server/effects/term.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

using testing::Contains;

struct Axis {
  std::vector<double> time_s, dwell_s, x_mm, t01, t02;
};

constexpr std::size_t kRows = 400;

Axis moved(std::mt19937_64& random) {
  Axis axis;
  double now_s = 0;
  for (std::size_t i = 0; i < kRows; ++i) {
    axis.x_mm.push_back(static_cast<double>(random() % 9) - 4);
    axis.dwell_s.push_back(static_cast<double>(3 * (1 + random() % 20)));
    now_s += 2 + axis.dwell_s.back();
    axis.time_s.push_back(now_s);
    axis.t01.push_back(21 + 0.4 * std::sin(now_s / 1900));
    axis.t02.push_back(21 + 0.3 * std::sin(now_s / 700 + 1));
  }
  return axis;
}

// Five nm of noise, a path of temperature and what is hidden.
Diagnosis diagnosed_axis(const Axis& axis, std::mt19937_64& random,
                         const std::function<double(std::size_t)>& hidden_nm) {
  std::normal_distribution<double> noise(0, 5);
  std::vector<double> q;
  for (std::size_t i = 0; i < kRows; ++i)
    q.push_back(axis.x_mm[i] + 1e-6 * (80 * (axis.t01[i] - 21) + noise(random) + hidden_nm(i)));
  Dataset data;
  data.rows = kRows;
  data.time_s = axis.time_s;
  data.dwell_s = axis.dwell_s;
  for (std::size_t i = 0; i < kRows; ++i)
    data.set.push_back(i % 4 == 3 ? PointSet::validation : PointSet::calibration);
  data.columns = {{{"q1", "mm"}, q},
                  {{"x", "mm"}, axis.x_mm},
                  {{"t01", "degC"}, axis.t01},
                  {{"t02", "degC"}, axis.t02}};
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + x^2 + T")->expand(data);
  options.nulls = 49;
  return *diagnose(data, options);
}

std::vector<std::string> names_in(const Diagnosis& found) {
  std::vector<std::string> names;
  for (const auto& finding : found.findings) names.push_back(finding.cause);
  return names;
}

TEST(DiagnosisNames, AnInstrumentWhoseScaleDriftsIsNotTheRobotsExpansion) {
  std::mt19937_64 random(7);
  const Axis axis = moved(random);
  const auto found = diagnosed_axis(axis, random, [&](std::size_t i) {
    return -0.8 * axis.x_mm[i] * axis.time_s[i] / 3600;  // x reads 0.8 ppm/h more
  });
  ASSERT_THAT(names_in(found), testing::ElementsAre("instrument_drift"));
  const auto& drift = found.findings.front();
  EXPECT_EQ(drift.applies_to, effects::AppliesTo::correction);
  const auto scale = std::ranges::find_if(drift.parameters, [](const FoundParameter& parameter) {
    return parameter.name.starts_with("ppm_per_h");  // "_x" where the zero drifts beside it
  });
  ASSERT_NE(scale, drift.parameters.end());
  EXPECT_NEAR(scale->value, 0.8, 0.15);
  EXPECT_THAT(drift.sentence, testing::HasSubstr("scale of x drifts"));
}

TEST(DiagnosisNames, TwoTimeConstantsAreOneCause) {
  std::mt19937_64 random(8);
  const Axis axis = moved(random);
  const auto relaxed = [&](std::size_t at, double tau_s) {
    double left_mm = 0;
    for (std::size_t i = 1; i <= at; ++i)
      left_mm += (axis.x_mm[i] - axis.x_mm[i - 1]) *
                 std::exp(-(axis.time_s[at] - axis.time_s[i] + axis.dwell_s[i]) / tau_s);
    return left_mm;
  };
  const auto found = diagnosed_axis(
      axis, random, [&](std::size_t i) { return 25 * relaxed(i, 8) + 12 * relaxed(i, 150); });
  ASSERT_THAT(names_in(found), testing::ElementsAre("creep"));
  const auto& parameters = found.findings.front().parameters;
  ASSERT_THAT(parameters, Contains(testing::Field(&FoundParameter::name, "further_tau_s")));
  const auto [low, high] = std::minmax(parameters[0].value, parameters[1].value);
  EXPECT_NEAR(low, 8, 2);
  EXPECT_NEAR(high, 150, 60);
}

TEST(DiagnosisNames, AFewPercentOfWrongRowsAreWrongRows) {
  std::mt19937_64 random(9);
  const Axis axis = moved(random);
  const auto found = diagnosed_axis(axis, random, [](std::size_t i) {
    return i % 29 == 11 ? 158.0 : 0.0;  // a missed half fringe, 3.5 %
  });
  ASSERT_THAT(names_in(found), testing::ElementsAre("outliers"));
  EXPECT_EQ(found.findings.front().rows.size(), 14U);
  EXPECT_EQ(found.verdict, Verdict::extended);
}

TEST(DiagnosisNames, ABumpAtOnePlaceIsNoWrongRow) {
  std::mt19937_64 random(10);
  Axis axis = moved(random);
  for (std::size_t i = 0; i < kRows; ++i)  // 35 places, none of them visited twice in a row
    axis.x_mm[i] = 0.2 * static_cast<double>((i * 12) % 35) - 3.4;
  const auto found = diagnosed_axis(axis, random, [&](std::size_t i) {
    return std::abs(axis.x_mm[i] - 1.4) < 0.05 ? 90.0 : 0.0;
  });
  EXPECT_THAT(names_in(found), testing::Not(Contains("outliers")));
  EXPECT_EQ(found.verdict, Verdict::unexplained);
}

}  // namespace
}  // namespace driftwise::diagnosis
