// Confounded plans: the set that these data cannot tell apart, the plan that would, and that plan
// run on the plant: it does.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/diagnosis/separating.h"
#include "server/formats/formula.h"
#include "server/simulation/planned_rows.h"
#include "tests/hidden_effects/plant_cases.h"

namespace driftwise::hidden {
namespace {

constexpr int kNulls = 99;

calibration::Candidates expanded(const std::string& formula, const Dataset& data) {
  return *formats::Formula::parse(formula)->expand(data);
}

diagnosis::SeparatingPlan plan_for(const std::string& baseline, const Dataset& data,
                                   const diagnosis::Diagnosis& found) {
  auto limits = diagnosis::limits_from(data);
  limits.simulations = 100;
  const auto plan = diagnosis::separating_plan(data, expanded(baseline, data), found, limits);
  EXPECT_TRUE(plan) << (plan ? "" : plan.error().message);
  if (!plan || !*plan) return {};
  return **plan;
}

std::string said(const diagnosis::Diagnosis& found) {
  std::string text;
  for (const auto& finding : found.findings) {
    text += finding.cause + " " + finding.subject;
    for (const auto& rival : finding.indistinguishable_from) text += " ~ " + rival;
    text += "; ";
  }
  return text;
}

bool in_a_set(const diagnosis::Diagnosis& found, const std::string& cause) {
  return std::ranges::any_of(found.findings, [&](const auto& finding) {
    return finding.cause == cause ||
           std::ranges::any_of(finding.indistinguishable_from,
                               [&](const auto& rival) { return rival.starts_with(cause + " "); });
  });
}

Dataset rows_of_run(const Dataset& data, std::int64_t run) {
  Dataset part = data;
  std::vector<std::size_t> keep;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.run[i] == run) keep.push_back(i);
  const auto pick = [&](auto& list) {
    if (list.empty()) return;
    auto old = list;
    list.clear();
    for (const std::size_t i : keep) list.push_back(old[i]);
  };
  pick(part.time_s);
  pick(part.set);
  pick(part.line);
  pick(part.zero);
  pick(part.dwell_s);
  pick(part.run);
  for (auto& column : part.columns) pick(column.values);
  part.rows = keep.size();
  return part;
}

// One dwell for all points: friction looks like creep, and creep like friction.
TEST(SeparatingOnThePlant, TellsBacklashFromCreepByDwells) {
  const std::string baseline = "q1 ~ x + x^2 + T";
  const PlantStart start{
      .seed = 1,
      .overrides = {"hidden.rub={kind=\"friction\",axis=1,friction_n=0.3,stiffness_n_um=10,"
                    "presliding_um=1}"}};
  const auto confounded = run_on_axis(start, {published_axis_plan(28)});
  const auto first = diagnosed_run(baseline, confounded.data, kNulls);
  ASSERT_TRUE(in_a_set(first, "backlash") && in_a_set(first, "creep")) << said(first);
  const auto plan = plan_for(baseline, confounded.data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_GE(*plan.predicted_power, 0.95);
  const auto both = run_on_axis(start, {published_axis_plan(28), *plan.trajectory});
  const auto second = diagnosed_run(baseline, rows_of_run(both.data, 2), kNulls);
  EXPECT_TRUE(in_a_set(second, "backlash")) << plan.why << ": " << said(second);
  EXPECT_FALSE(in_a_set(second, "creep")) << plan.why << ": " << said(second);
}

// Steps of 1.5 um under a scale whose signals repeat every 2 um: a wave of 6 um is seen.
TEST(SeparatingOnThePlant, FindsTheShorterPeriodBehindAGridThatAliasesIt) {
  const std::string baseline = "q1 ~ x";
  const PlantStart start{
      .seed = 2,
      .overrides = {"hidden.signals={kind=\"scale_signals\",axis=1,period_nm=2000,offset_pct=6,"
                    "amplitude_pct=0,phase_deg=0}"}};
  Trajectory grid;
  grid.coordinates = {{"q1", "mm"}};
  for (int k = 0; k < 400; ++k) {
    TrajectoryPoint point;
    point.target_mm = {1.5e-3 * (k * 17 % 41 - 20)};
    point.set = k % 3 == 2 ? PointSet::validation : PointSet::calibration;
    point.line = k / 40;
    grid.points.push_back(point);
  }
  const auto confounded = run_on_axis(start, {grid});
  const auto first = diagnosed_run(baseline, confounded.data, kNulls);
  const auto periodic = [](const diagnosis::Diagnosis& found) -> const diagnosis::Finding* {
    for (const auto& finding : found.findings)
      if (finding.cause == "cyclic_error") return &finding;
    return nullptr;
  };
  ASSERT_NE(periodic(first), nullptr) << said(first);
  EXPECT_NEAR(periodic(first)->parameters.front().value, 6000, 150);
  const auto plan = plan_for(baseline, confounded.data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_GE(*plan.predicted_power, 0.95);
  const auto both = run_on_axis(start, {grid, *plan.trajectory});
  const auto second = diagnosed_run(baseline, rows_of_run(both.data, 2), kNulls);
  ASSERT_NE(periodic(second), nullptr) << plan.why << ": " << said(second);
  EXPECT_NEAR(periodic(second)->parameters.front().value, 2000, 30);
}

// Force rising with temperature, made by hand: 12 nm/N, and t07 warms with the load. The plan is
// "run" by the truth.
class ForceWithWarmth {
 public:
  Dataset measured(const Dataset& planned) {
    Dataset rows = planned;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      const double x_mm = rows.values_of("x")[i], force_n = rows.values_of("force")[i];
      for (auto& column : rows.columns)
        if (column.channel.symbol == "q1")
          column.values[i] = 1.001 * x_mm + (12 * force_n + 4 * noise_(random_)) * 1e-6;
    }
    return rows;
  }
  Dataset rising() {
    Dataset rows;
    rows.columns = {
        {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"force", "N"}, {}}, {{"t07", "degC"}, {}}};
    rows.rows = 360;
    for (std::size_t i = 0; i < rows.rows; ++i) {
      const double force_n = static_cast<double>(i / 90);
      rows.time_s.push_back(20.0 * static_cast<double>(i));
      rows.set.push_back(i % 4 == 3 ? PointSet::validation : PointSet::calibration);
      rows.columns[0].values.push_back(0);
      rows.columns[1].values.push_back(-2 + 0.5 * static_cast<double>(i * 7 % 9));
      rows.columns[2].values.push_back(force_n);
      rows.columns[3].values.push_back(20 + 0.5 * force_n + 0.002 * noise_(random_));
    }
    return measured(rows);
  }

 private:
  std::mt19937_64 random_{5};
  std::normal_distribution<double> noise_;
};

TEST(SeparatingByForces, TellsForceFromTheTemperatureThatRoseWithIt) {
  ForceWithWarmth world;
  const std::string baseline = "q1 ~ x";
  const auto data = world.rising();
  const auto first = diagnosed_run(baseline, data, kNulls);
  ASSERT_TRUE(in_a_set(first, "force_compliance") && in_a_set(first, "thermal_offset"))
      << said(first);
  const auto plan = plan_for(baseline, data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_NE(plan.why.find("forces in random order"), std::string::npos) << plan.why;
  calibration::FitOptions fitting;
  fitting.candidates = expanded(baseline, data);
  fitting.select = calibration::Select::all;
  const auto model = calibration::fit(data, fitting);
  ASSERT_TRUE(model);
  auto planned = simulation::planned_rows(*model, *plan.trajectory,
                                          {{{"t07", "degC"}, 21.5}, {{"force", "N"}, 0.0}}, {}, 0);
  ASSERT_TRUE(planned) << planned.error().message;
  std::mt19937_64 room(9);
  std::normal_distribution<double> wander(0, 0.02);
  for (auto& column : planned->columns)
    if (column.channel.symbol == "t07")
      for (double& degc : column.values) degc += wander(room);
  const auto second = diagnosed_run(baseline, world.measured(*planned), kNulls);
  EXPECT_TRUE(in_a_set(second, "force_compliance")) << said(second);
  EXPECT_FALSE(in_a_set(second, "thermal_offset")) << said(second);
}

}  // namespace
}  // namespace driftwise::hidden
