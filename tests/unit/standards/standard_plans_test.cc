// A trajectory is right when a perfect robot that runs it has the standard's figures, all of them
// zero.

#include "server/standards/standard_plans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "server/formats/csv/trajectory_csv.h"
#include "server/standards/iso230_2.h"
#include "server/standards/iso230_3.h"
#include "server/standards/iso9283.h"

namespace driftwise::standards {
namespace {

// 8 s per point and what it dwells; motor coordinates and pose are the same.
Dataset run_perfectly(const Trajectory& trajectory) {
  Dataset data;
  data.rows = trajectory.points.size();
  const std::size_t axes = trajectory.coordinates.size();
  const char* const pose[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < axes; ++i) {
    data.columns.push_back({{trajectory.coordinates[i].symbol + "_cmd", "mm"}, {}});
    data.columns.push_back({{pose[i], "mm"}, {}});
  }
  double time_s = 0;
  for (const auto& point : trajectory.points) {
    data.time_s.push_back(time_s += 8 + point.dwell_s.value_or(0));
    data.zero.push_back(point.zero ? 1 : 0);
    for (std::size_t i = 0; i < axes; ++i) {
      data.columns[2 * i].values.push_back(point.target[i]);
      data.columns[2 * i + 1].values.push_back(point.target[i]);
    }
  }
  return data;
}

// The same with play in the first axis, and as a cell runs it: between two lines without a zero row
// the axes return to zero, in no row (server/application/runs/trajectory_walk.h).
Dataset run_with_play(const Trajectory& trajectory, double play_nm) {
  Dataset data = run_perfectly(trajectory);
  double from_mm = 0, left_mm = 0;
  const auto move_to = [&](double to_mm) {
    if (to_mm != from_mm) left_mm = (to_mm > from_mm ? -0.5 : 0.5) * play_nm * 1e-6;
    from_mm = to_mm;
  };
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const auto& point = trajectory.points[i];
    if (i > 0 && point.line != trajectory.points[i - 1].line) move_to(0);
    move_to(point.target[0]);
    data.columns[1].values[i] += left_mm;
  }
  return data;
}

Trajectory must(Result<Trajectory> plan) {
  EXPECT_TRUE(plan) << plan.error().message;
  const auto again = formats::read_trajectory_csv(formats::write_trajectory_csv(*plan), "plan.csv");
  EXPECT_TRUE(again) << again.error().message;
  return *plan;
}

TEST(Iso2302Plan, GivesARunThatHasItsFigures) {
  for (const std::uint32_t seed : {1U, 2U, 77U})
    for (const int positions : {5, 9, 21}) {
      const auto plan = must(iso230_2_plan(
          {.from_mm = -4, .to_mm = 4, .positions = positions, .seed = seed, .held = {}}));
      const auto found = iso230_2(run_perfectly(plan), {});
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->positions.size(), static_cast<std::size_t>(positions));
      EXPECT_EQ(found->turning_points_mm.size(), 2U);
      EXPECT_EQ(found->a.both_nm, 0);
      EXPECT_EQ(found->b_nm, 0);
      EXPECT_TRUE(found->warnings.empty()) << found->warnings[0];
    }
}

TEST(Iso2302Plan, ShowsPlayAlikeAtEveryPositionThoughTheAxisReturnsToZeroBetweenPasses) {
  constexpr double kPlay_nm = 600;
  for (const auto& [from_mm, to_mm] : {std::pair(-4.0, 4.0), {1.0, 3.0}, {-3.0, -1.0}, {0.0, 5.0}})
    for (const double overrun_mm : {0.0, 0.1}) {
      const auto plan = must(iso230_2_plan(
          {.from_mm = from_mm, .to_mm = to_mm, .overrun_mm = overrun_mm, .held = {}}));
      const auto found = iso230_2(run_with_play(plan, kPlay_nm), {});
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->positions.size(), 9U);
      for (const auto& position : found->positions) {
        EXPECT_NEAR(position.reversal_nm, -kPlay_nm, 1e-3)
            << "at " << position.target_mm << " mm of " << from_mm << " to " << to_mm;
        EXPECT_NEAR(position.r_nm, kPlay_nm, 1e-3);
      }
    }
}

TEST(Iso2302Plan, ScattersItsPositionsWithinTheRange) {
  const auto plan = must(iso230_2_plan({.from_mm = -4, .to_mm = 4, .held = {}}));
  std::set<double> steps;
  for (std::size_t i = 3; i < 11; ++i) {
    const double step = plan.points[i].target[0] - plan.points[i - 1].target[0];
    EXPECT_GT(step, 0);
    steps.insert(step);
  }
  EXPECT_GT(steps.size(), 6U) << "uneven";
  for (const auto& point : plan.points) EXPECT_LE(std::abs(point.target[0]), 4.25);
}

TEST(Iso2302Plan, HoldsTheOtherAxes) {
  const auto plan = must(iso230_2_plan({.axis = {"q2", "mm"},
                                        .from_mm = 0.5,
                                        .to_mm = 2,
                                        .held = {{{"q1", "mm"}, 1.25}, {{"q3", "mm"}, 1}}}));
  ASSERT_EQ(plan.coordinates.size(), 3U);
  EXPECT_EQ(plan.coordinates[0].symbol, "q1");
  for (const auto& point : plan.points)
    if (!point.zero) {
      EXPECT_EQ(point.target[0], 1.25);
      EXPECT_EQ(point.target[2], 1);
    }
  const auto found = iso230_2(run_perfectly(plan), {.columns = {"q2", "", ""}});
  EXPECT_TRUE(found) << found.error().message;
}

TEST(Iso2303Plan, GivesARunThatHasItsFigures) {
  for (const std::vector<double>& at_mm : {std::vector<double>{4, -4}, {1.25}}) {
    const auto plan = must(iso230_3_plan({.at_mm = at_mm, .held = {}}));
    const auto found = iso230_3(run_perfectly(plan), {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_GE(found->series.size(), at_mm.size());
    EXPECT_EQ(found->range_nm, 0);
  }
}

TEST(Iso2303Plan, VisitsAlwaysFromBelowOrRestsThoughTheAxisReturnsToZeroBetweenRounds) {
  for (const std::vector<double>& at_mm : {std::vector<double>{4, -4}, {1, 3}, {-3, -1}, {-1.25}}) {
    const auto plan = must(iso230_3_plan({.at_mm = at_mm, .held = {}}));
    const auto found = iso230_3(run_with_play(plan, 600), {});
    ASSERT_TRUE(found) << found.error().message;
    for (const auto& series : found->series) EXPECT_EQ(series.range_nm, 0) << series.target_mm;
  }
  const auto at_rest = must(iso230_3_plan({.at_mm = {1.25}, .held = {}}));
  for (std::size_t i = 2; i < at_rest.points.size(); ++i)
    EXPECT_EQ(at_rest.points[i].line, at_rest.points[1].line) << "no return to zero at rest";
}

TEST(Iso9283Plan, ApproachesEachPoseFromTheSameOne) {
  const auto plan = must(iso9283_plan(
      {.axes = {{"q1", "mm"}, {"q2", "mm"}}, .centre_mm = {2, 2}, .edge_mm = 2, .held = {}}));
  const auto found = iso9283(run_with_play(plan, 600), {});
  ASSERT_TRUE(found) << found.error().message;
  for (const auto& pose : found->poses) EXPECT_NEAR(pose.rp_nm, 0, 1e-3);
  for (std::size_t i = 2; i + 1 < plan.points.size(); ++i)
    EXPECT_EQ(plan.points[i].line, plan.points[1].line) << "no return to zero between cycles";
}

TEST(Iso9283Plan, GivesARunThatHasItsFigures) {
  for (std::size_t axes = 1; axes <= 3; ++axes) {
    Iso9283Plan plan{.axes = {}, .centre_mm = {}, .edge_mm = 2, .held = {}};
    for (std::size_t i = 0; i < axes; ++i) {
      plan.axes.push_back({"q" + std::to_string(i + 1), "mm"});
      plan.centre_mm.push_back(1.25);
    }
    const auto found = iso9283(run_perfectly(must(iso9283_plan(plan))), {});
    ASSERT_TRUE(found) << axes << ": " << found.error().message;
    EXPECT_EQ(found->poses.size(), 5U);
    EXPECT_EQ(found->poses[4].cycles, 30U);
    EXPECT_EQ(found->worst_ap_nm, 0);
  }
}

TEST(StandardPlans, RefuseWhatTheStandardDoesNotKnow) {
  EXPECT_EQ(iso230_2_plan({.from_mm = 1, .to_mm = 1, .held = {}}).error().reason, "BAD_PLAN");
  EXPECT_FALSE(iso230_2_plan({.from_mm = 0, .to_mm = 1, .positions = 4, .held = {}}));
  EXPECT_FALSE(iso230_2_plan({.from_mm = 0, .to_mm = 1, .approaches = 3, .held = {}}));
  EXPECT_FALSE(iso230_2_plan({.from_mm = 0, .to_mm = 1, .scatter = 0.5, .held = {}}));
  EXPECT_FALSE(iso230_3_plan({.at_mm = {}, .held = {}}));
  EXPECT_FALSE(iso230_3_plan({.at_mm = {0}, .hours = 1e6, .every_s = 1, .held = {}}));
  EXPECT_FALSE(
      iso9283_plan({.axes = {{"q1", "mm"}}, .centre_mm = {0, 1}, .edge_mm = 1, .held = {}}));
  EXPECT_FALSE(iso9283_plan({.axes = {{"q1", "mm"}}, .centre_mm = {0}, .edge_mm = 0, .held = {}}));
}

}  // namespace
}  // namespace driftwise::standards
