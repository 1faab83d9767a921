// Confounded plans: the set that these data cannot tell apart, the plan that would, and that plan
// run on the plant: it does.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/diagnosis/separating/separating.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/plants/plant_cases.h"

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

// Both runs together, as `driftwise improve` looks at them.
diagnosis::Diagnosis after(const std::string& baseline, const PlantRun& both) {
  return diagnosed_run(baseline, both.data, kNulls);
}

// One dwell for all points: friction looks like creep, and creep like friction.
TEST(SeparatingOnThePlant, TellsBacklashFromCreepByDwells) {
  const std::string baseline = "q1 ~ x + x^2 + T";
  const auto published = published_axis_plan(56);
  const PlantStart start{
      .seed = 1,
      .overrides = {"hidden.rub={kind=\"friction\",axis=1,friction_n=0.3,stiffness_n_um=10,"
                    "presliding_um=1}"}};
  const auto confounded = run_on_axis(start, {published});
  const auto first = diagnosed_run(baseline, confounded.data, kNulls);
  ASSERT_TRUE(in_a_set(first, "backlash") && in_a_set(first, "creep")) << said(first);
  const auto plan = plan_for(baseline, confounded.data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_GE(*plan.predicted_power, 0.95);
  const auto second = after(baseline, run_on_axis(start, {published, *plan.trajectory}));
  EXPECT_TRUE(in_a_set(second, "backlash")) << plan.why << ": " << said(second);
  EXPECT_FALSE(in_a_set(second, "creep")) << plan.why << ": " << said(second);
}

// Steps of 1.5 um under a scale whose signals repeat every 2 um: a wave of 6 um passes through the
// same values.
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
    point.target = {1.5e-3 * (k * 17 % 41 - 20)};
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
  const double seen_nm = periodic(first)->parameters.front().value;
  EXPECT_TRUE(std::abs(seen_nm - 6000) < 150 || std::abs(seen_nm - 2000) < 30) << seen_nm;
  const auto plan = plan_for(baseline, confounded.data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_GE(*plan.predicted_power, 0.95);
  EXPECT_NE(plan.why.find(seen_nm > 4000 ? "of 2000 nm" : "of 6"), std::string::npos) << plan.why;
  const auto second = after(baseline, run_on_axis(start, {grid, *plan.trajectory}));
  ASSERT_NE(periodic(second), nullptr) << plan.why << ": " << said(second);
  EXPECT_NEAR(periodic(second)->parameters.front().value, 2000, 30);
}

// A Micro-Nano whose parts do not expand, in a room that warms, without autocollimators, under a
// force that rises as t05 does: force or temperature, nobody can say.
class ForceThatRisesWithTheRoom : public testing::Test {
 protected:
  static constexpr std::size_t kPoints = 360;
  static constexpr double kLargest_n = 0.3, kGrain_n = 0.005;

  PlantStart start() const {
    PlantStart start{.seed = 3, .overrides = {"room.balance_degc=24", "room.wander_w=0"}};
    for (const char* material :
         {"titanium", "steel", "aluminium", "invar", "g10", "honeycomb", "pasteboard"})
      start.overrides.push_back(std::string("material.") + material + ".expansion_ppm_k=0.02");
    return start;
  }
  // 0.1 mm about one pose: geometry of second order is enough.
  Trajectory under(const std::vector<double>& forces_n) const {
    static constexpr std::array kTurns = {0.7548776662, 0.5698402910, 0.8191725134};
    Trajectory plan;
    plan.coordinates = {{"q1", "mm"}, {"q2", "mm"}, {"q3", "mm"}};
    for (std::size_t i = 0; i < forces_n.size(); ++i) {
      TrajectoryPoint point;
      for (const double turn : kTurns) {
        const double turned = static_cast<double>(i + 1) * turn;
        point.target.push_back(1.2 + 0.1 * (turned - std::floor(turned)));
      }
      point.set = i % 4 == 3 ? PointSet::validation : PointSet::calibration;
      point.line = static_cast<std::int64_t>(i / 15);
      point.force_n = forces_n[i];
      point.dwell_s = 8;
      plan.points.push_back(std::move(point));
    }
    return plan;
  }
  static PlantRun run(const PlantStart& start, const std::vector<Trajectory>& plans) {
    PlantRun run = run_on_micro_nano(start, plans);
    std::erase_if(run.data.columns,
                  [](const auto& column) { return column.channel.symbol.front() == 'r'; });
    return run;
  }
  // The day's temperatures are seen under a force that rises evenly, then followed.
  Trajectory confounded() const {
    std::vector<double> forces_n(kPoints);
    for (std::size_t i = 0; i < kPoints; ++i)
      forces_n[i] = grained(kLargest_n * static_cast<double>(i) / kPoints);
    const auto day = run(start(), {under(forces_n)});
    const auto t05 = day.data.values_of("t05");
    for (std::size_t i = 0; i < kPoints; ++i)
      forces_n[i] = grained(kLargest_n * std::max(0.0, t05[i] - t05[0]) / (t05.back() - t05[0]));
    return under(forces_n);
  }
  static double grained(double newton) { return std::round(newton / kGrain_n) * kGrain_n; }
};

TEST_F(ForceThatRisesWithTheRoom, IsToldFromItsTemperatureByForcesInRandomOrder) {
  // The diagnosis of 2026-11-22 reports geometry of higher order here, where it reported the set
  // {force_compliance, thermal_offset} before.
  const std::string baseline = "q ~ poly(x, y, z, 2)";
  const auto day = confounded();
  const auto seen = run(start(), {day});
  const auto first = diagnosed_run(baseline, seen.data, kNulls);
  ASSERT_TRUE(in_a_set(first, "force_compliance") && in_a_set(first, "thermal_offset"))
      << said(first);
  const auto plan = plan_for(baseline, seen.data, first);
  ASSERT_TRUE(plan.trajectory) << plan.why;
  EXPECT_GE(*plan.predicted_power, 0.95);
  const auto second = after(baseline, run(start(), {day, *plan.trajectory}));
  EXPECT_TRUE(in_a_set(second, "force_compliance")) << plan.why << ": " << said(second);
  EXPECT_FALSE(in_a_set(second, "thermal_offset")) << plan.why << ": " << said(second);
}

}  // namespace
}  // namespace driftwise::hidden
