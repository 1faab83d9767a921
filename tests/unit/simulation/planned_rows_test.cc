#include "server/simulation/planned_rows.h"

#include <gtest/gtest.h>

namespace driftwise::simulation {
namespace {

using effects::Power;
using effects::Term;

// q1 = 0.01 + 1.002 x - 2e-4 t07
calibration::Model planned_axis() {
  calibration::Model model;
  calibration::OutputModel out;
  out.channel = {"q1", "mm"};
  out.terms = {Term{}, Term{{Power{"x", 1}}}, Term{{Power{"t07", 1}}}};
  out.coefficients = Eigen::Vector3d(0.01, 1.002, -2e-4);
  model.outputs = {out};
  model.domain = {{{"x", "mm"}, -4, 4}, {{"t07", "degC"}, 20, 22}};
  return model;
}

Trajectory three_points() {
  Trajectory trajectory;
  trajectory.coordinates = {{"q1", "mm"}};
  TrajectoryPoint empty, loaded, bare;
  empty.target = {1};
  empty.force_n = 0.0;
  loaded.target = {-1};
  loaded.force_n = 2.0;
  loaded.dwell_s = 100.0;
  bare.target = {-1};
  bare.set = PointSet::validation;
  trajectory.points = {empty, loaded, bare};
  return trajectory;
}

TEST(PlannedRows, TakeTheTimeThatMovesWaitsAndWeightsTake) {
  const MotionTimes times{.velocity_mm_s = 2, .settle_s = 1, .reading_s = 4, .load_s = 30};
  const auto when = point_times(three_points(), times);
  // 0.5 s of move, 1 s to settle, half of 4 s; then 30 s, 1 s, 1 + 100 + 2 s; then no move.
  EXPECT_EQ(when.time_s, (std::vector<double>{3.5, 5.5 + 30 + 1 + 103, 5.5 + 30 + 1 + 105 + 3}));
  EXPECT_EQ(when.dwell_s, (std::vector<double>{3, 103, 3}));
  EXPECT_DOUBLE_EQ(when.total_s, 5.5 + 136 + 5);
}

TEST(PlannedRows, ReadWhatTheModelSaysForward) {
  const auto rows =
      planned_rows(planned_axis(), three_points(), {{{"t07", "degC"}, 21.0}}, {}, 500);
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->rows, 3U);
  EXPECT_NEAR(rows->values_of("x")[0], (1 - 0.01 + 2e-4 * 21) / 1.002, 1e-12);
  EXPECT_EQ(rows->values_of("t07")[2], 21);
  EXPECT_EQ(rows->values_of("force")[1], 2);
  EXPECT_EQ(rows->values_of("force")[2], 2);  // what hangs stays
  EXPECT_GT(rows->time_s[0], 500);
  EXPECT_EQ(rows->set_of(2), PointSet::validation);
}

TEST(PlannedRows, SayWhatTheModelMisses) {
  const auto rows = planned_rows(planned_axis(), three_points(), {}, {}, 0);
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().reason, "UNKNOWN_CHANNEL");
}

}  // namespace
}  // namespace driftwise::simulation
