// Rotations as coordinates: wanted, compensated, gated and closed like lengths, in arcsec.

#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

CellDescription turning_cell(const std::string& database, double u_arcsec = 0.01) {
  auto cell = small_cell(database);
  cell.devices[2].become<AngleSettings>().angles = {{{"rx", "arcsec"}, 1, 1, u_arcsec}};
  return cell;
}

class Turning : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, turning_cell(folder / "cell.sqlite"), kSqlite};

  double value_of(const PointRecord& point, const std::string& channel) const {
    for (const auto& value : point.values)
      if (value.channel == channel) return value.value;
    return kMissing;
  }
};

TEST_F(Turning, AWantedRotationIsReachedByAModel) {
  const auto campaign = cell.begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true));
  ASSERT_EQ(cell.finish_run().state, RunState::done);
  application::FitRequest fit;
  fit.runs = {campaign.id};
  fit.formula = "q1 ~ rx";
  const auto model = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model->id, true)));
  application::CreateRun request;
  request.trajectory_text = "rx_deg,set\n0.01,validation\n-0.005,validation\n";
  const auto uncompensated = cell.try_run(request);
  ASSERT_FALSE(uncompensated);
  EXPECT_EQ(uncompensated.error().reason, "NEEDS_COMPENSATION");
  request.compensate = true;
  const auto run = cell.try_run(request);
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(cell.finish_run().state, RunState::done);
  const auto points = *cell.await(cell.points(run->id, 0, 10));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(value_of(points[0], "rx_target_arcsec"), 36);
  EXPECT_EQ(value_of(points[1], "rx_target_arcsec"), -18);
  for (const auto& point : points)  // 200 nm of the axis: its holding, and the warming robot
    EXPECT_NEAR(value_of(point, "rx_arcsec"), value_of(point, "rx_target_arcsec"), 0.002);
}

// Half an arcsec to either side, in five readings of a point.
std::string first_reason(CellInMemory& cell, SmallWorld& world) {
  world.disturbance_nm = 50e3;
  const auto run = cell.begin_run(lines_of(1, {2}, true));
  cell.until([&] { return cell.status().run->run.accepted == 1; });
  world.disturbed_readings = 5;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto attempts = *cell.await(cell.attempts(run.id));
  for (const auto& attempt : attempts)
    if (!attempt.reason.empty()) return attempt.reason;
  return "";
}

TEST_F(Turning, ReadingsThatScatterAreReadAgain) {
  const auto reason = first_reason(cell, world);
  EXPECT_THAT(reason, HasSubstr("spread of rx_arcsec"));
  EXPECT_THAT(reason, HasSubstr("arcsec of 4 readings, limit 0.2 arcsec"));
}

TEST(TurningByCoarseSteps, ScatterByWhatTheInstrumentDeclaresIsNoFault) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, turning_cell(folder / "cell.sqlite", 1), kSqlite};
  EXPECT_EQ(first_reason(cell, world), "");
}

TEST_F(Turning, AZeroThatTurnedIsToldWithItsOwnLimit) {
  cell.begin_run(lines_of(3, {2, -3}, true));
  cell.until([&] { return cell.status().run->run.accepted == 2; });
  world.zero_mm += 0.3;  // 3 arcsec: somebody touched the mirror
  ASSERT_EQ(cell.finish_run().state, RunState::done);
  const auto told = cell.events_named("closure.bad");
  ASSERT_FALSE(told.empty());
  EXPECT_THAT(told.front(), HasSubstr("rx turned by -3.0"));
  EXPECT_THAT(told.front(), HasSubstr("arcsec (limit 2)"));
}

}  // namespace
}  // namespace driftwise::tests
