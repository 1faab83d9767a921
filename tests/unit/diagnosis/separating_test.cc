#include "server/diagnosis/separating/separating.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/diagnosis/rows/aliases.h"
#include "server/diagnosis/separating/separating_power.h"

namespace driftwise::diagnosis {
namespace {

TEST(Aliases, LookTheSameOnTheGrid) {
  const auto aliases = aliased_periods(6.0, 1.5);
  ASSERT_FALSE(aliases.empty());
  EXPECT_NEAR(aliases.front(), 2.0, 1e-12);  // 1 / (1/1.5 - 1/6)
  for (const double alias : aliases)
    for (int k = -20; k <= 20; ++k)
      EXPECT_NEAR(std::cos(2 * std::numbers::pi * k * 1.5 / alias),
                  std::cos(2 * std::numbers::pi * k * 1.5 / 6.0), 1e-9);
  EXPECT_TRUE(aliased_periods(6.0, 0).empty());
}

TEST(Lattice, IsFoundThroughTheHoldingError) {
  std::vector<double> places;
  for (int k = 0; k < 40; ++k) places.push_back(0.5 * (k % 17) + 3e-5 * (k % 3 - 1));
  EXPECT_NEAR(lattice_spacing(places, 1e-4), 0.5, 1e-5);
  places.push_back(0.263);
  EXPECT_EQ(lattice_spacing(places, 1e-4), 0);
}

// Each visit of a place ends a twelfth of a step elsewhere: the gaps between places are all too
// short, and a count in them slips over forty steps.
TEST(Lattice, IsFoundWhereVisitsOfOnePlaceSpread) {
  std::vector<double> places;
  for (int k = 0; k < 400; ++k)
    places.push_back(1500.0 * (k * 17 % 41 - 20) + 125.0 * ((k * 7 % 11) / 10.0 - 0.7));
  EXPECT_NEAR(lattice_spacing(places, 80), 1500, 5);
}

// More forces than a plan can hang: those kept span the range.
TEST(SeparatingLimits, KeepTheSmallestAndTheLargestForce) {
  Dataset rows;
  rows.columns = {{{"q1", "mm"}, {}}, {{"force", "N"}, {}}};
  for (int k = 0; k <= 60; ++k) {
    rows.columns[0].values.push_back(k);
    rows.columns[1].values.push_back(0.005 * k);
  }
  rows.rows = 61;
  const auto forces_n = limits_from(rows).plan.forces_n;
  ASSERT_EQ(forces_n.size(), 12U);
  EXPECT_EQ(forces_n.front(), 0);
  EXPECT_DOUBLE_EQ(forces_n.back(), 0.3);
}

PlanLimits two_axes() {
  return {.coordinates = {{"q1", "mm"}, {"q2", "mm"}},
          .min = {-4, 0},
          .max = {4, 2.5},
          .forces_n = {0, 1.5, 3},
          .period = 2e-3};
}

TEST(SeparatingPlans, StayWithinTheLimits) {
  const auto limits = two_axes();
  const auto plans = candidate_plans(limits, 96);
  EXPECT_EQ(plans.size(), 7U);
  for (const auto& plan : plans) {
    EXPECT_GE(plan.trajectory.points.size(), 96U) << plan.what;
    for (const auto& point : plan.trajectory.points)
      for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_GE(point.target[k], limits.min[k]) << plan.what;
        EXPECT_LE(point.target[k], limits.max[k]) << plan.what;
      }
  }
}

TEST(SeparatingPlans, HangEachForceAsOftenInNoOrder) {
  auto plans = candidate_plans(two_axes(), 120);
  const auto& forces = plans[5].trajectory.points;
  std::vector<int> count(3);
  bool falls = false, rises = false;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    ++count[static_cast<std::size_t>(*forces[i].force_n / 1.5)];
    if (i == 0) continue;
    falls |= *forces[i].force_n < *forces[i - 1].force_n;
    rises |= *forces[i].force_n > *forces[i - 1].force_n;
  }
  EXPECT_TRUE(falls && rises);
  EXPECT_LE(*std::ranges::max_element(count) - *std::ranges::min_element(count), 4);
}

TEST(SeparatingPlans, WithoutForcesOrPeriodsLeaveThoseDesignsOut) {
  auto limits = two_axes();
  limits.forces_n = {0};
  limits.period.reset();
  EXPECT_EQ(candidate_plans(limits, 24).size(), 5U);
}

effects::Term called(const std::string& effect, std::vector<std::string> symbols, double value,
                     const std::string& unit) {
  return {{effects::Call{effect, std::move(symbols), {{value, unit}}}}};
}

Hypothesis hypothesis(const std::string& cause, effects::Term term, double size) {
  Hypothesis one{.cause = cause, .name = cause};
  HypothesisCell cell;
  cell.terms = {std::move(term)};
  cell.coefficients = Eigen::MatrixXd::Constant(1, 1, size);
  one.cells = {cell};
  return one;
}

Dataset rows_with_dwells(bool constant_dwell) {
  Dataset rows;
  rows.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  double time_s = 0;
  for (int k = 0; k < 120; ++k) {
    const double q = (k * 7 % 17) - 8;
    const double dwell_s = constant_dwell ? 10 : (k * k % 3 == 0 ? 1 : 100);
    time_s += 5 + dwell_s;
    rows.time_s.push_back(time_s);
    rows.dwell_s.push_back(dwell_s);
    rows.columns[0].values.push_back(q);
    rows.columns[1].values.push_back(q);
  }
  rows.rows = rows.time_s.size();
  return rows;
}

OutputSummary noisy(double white_nm) {
  OutputSummary output;
  output.output = "q1";
  output.unit = "nm";
  output.noise_white_sd = white_nm;
  output.noise_tau_s = 60;
  return output;
}

// A play of 60 nm: coefficient 1 per mm is 1e6 nm. Creep: 15 ppm of a move, 40 s.
std::vector<Hypothesis> play_or_creep() {
  return {hypothesis("backlash", called("play", {"q1"}, 60, "nm"), 1e6),
          hypothesis("creep", called("creep", {"q1", "dwell"}, 40, "s"), 10)};
}

TEST(SeparatingPower, GrowsWithContrastAndFallsWithNoise) {
  const auto base = std::vector<effects::Term>{{{effects::Power{"x", 1}}}};
  const auto power = [&](bool constant, double white_nm) {
    return *separating_power(rows_with_dwells(constant), base, play_or_creep(), {noisy(white_nm)},
                             200, 3);
  };
  EXPECT_GT(power(false, 5).power, 0.95);
  EXPECT_GT(power(false, 5).expected_2lnl, power(false, 20).expected_2lnl);
  EXPECT_LT(power(false, 200).power, 0.5);
}

TEST(SeparatingPower, IsNoneBetweenEquals) {
  const auto base = std::vector<effects::Term>{{{effects::Power{"x", 1}}}};
  auto twice = play_or_creep();
  twice[1] = twice[0];
  const auto power = *separating_power(rows_with_dwells(false), base, twice, {noisy(5)}, 100, 3);
  EXPECT_NEAR(power.expected_2lnl, 0, 1e-9);
  EXPECT_EQ(power.power, 0);
  EXPECT_EQ(power.classes, 1U);
}

// Two names for one thing stay together, and the plan is judged by what it does tell apart.
TEST(SeparatingPower, LeavesWhatItCannotTellInOneClass) {
  const auto base = std::vector<effects::Term>{{{effects::Power{"x", 1}}}};
  auto three = play_or_creep();
  three.insert(three.begin() + 1, three[0]);
  const auto power = *separating_power(rows_with_dwells(false), base, three, {noisy(5)}, 200, 3);
  EXPECT_EQ(power.classes, 2U);
  EXPECT_EQ(power.class_of, (std::vector<std::size_t>{0, 0, 1}));
  EXPECT_GT(power.expected_2lnl, kIdentifiable2lnl);
  EXPECT_GT(power.power, 0.95);
}

// 2 ln L of a known difference in white noise: its squared length over the variance, less what the
// mean takes up.
TEST(SeparatingPower, IsWhatTheArithmeticSays) {
  Dataset rows;
  rows.columns = {{{"q1", "mm"}, {}}, {{"a", "1"}, {}}, {{"b", "1"}, {}}};
  for (int k = 0; k < 64; ++k) {
    rows.time_s.push_back(k);
    rows.columns[0].values.push_back(k);
    rows.columns[1].values.push_back(k % 2 == 0 ? 1 : -1);
    rows.columns[2].values.push_back(k % 4 < 2 ? 1 : -1);
  }
  rows.rows = 64;
  const auto at = [](const char* symbol) { return effects::Term{{effects::Power{symbol, 1}}}; };
  const auto power = *separating_power(
      rows, {}, {hypothesis("one", at("a"), 3), hypothesis("other", at("b"), 3)}, {noisy(4)}, 0, 1);
  EXPECT_NEAR(power.expected_2lnl, 64 * (9.0 + 9.0) / 16, 1e-6);
}

}  // namespace
}  // namespace driftwise::diagnosis
