// Sensors with a voltage on the wire: driftwise-cellsim, driftwised and the record. An inclinometer
// and three triangulation sensors behind the scanner that reads the thermometers; a force sensor,
// the current of a motor, and a second autocollimator that confirms.

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "server/formats/csv/dataset_csv.h"
#include "tests/devices/keithley_2701/analogue_cells.h"
#include "tests/support/running_cell.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Dataset data_of(RunningCell& cell, const std::string& run) {
  auto data = formats::read_dataset_csv(cell.cli({"data", "export", run}).out, "export");
  if (!data) throw std::runtime_error(data.error().message);
  return std::move(*data);
}

TEST(AnalogueOnTheWire, PlateAndInclinometerMeasureInTheirSetUps) {
  const LargerCell files("min-angle", kPlateAndLevel, kSensorsOfThePlant);
  RunningCell cell({.speed = 200,
                    .cell = files.name(),
                    .cellsim_options = {"--set", "emulator.scanner.slot2=7700"}});
  cell.edit_cell_file("max_spread_nm = 150.0", "max_spread_nm = 2000.0");
  cell.edit_cell_file("max_drift_nm_per_min = 500.0", "max_drift_nm_per_min = 5000.0");
  cell.start_daemon();
  const std::string plan = (fs::path(cell.folder()) / "tilts.csv").string();
  // The last but one is beyond the sensors' range of +-9 mm for a moment: see the fault below.
  write_file(plan,
             "q1_mm,q2_mm,q3_mm,zero\n0,0,0,1\n1,1,1,0\n0.5,-0.5,-0.5,0\n-2,-2,-2,0\n0,0,0,1\n");

  const auto plate = cell.cli({"run", "start", plan, "--setup", "plate", "--watch"});
  ASSERT_EQ(plate.code, 0) << plate.err << cell.daemon_log();
  const auto heights = data_of(cell, "1");
  ASSERT_EQ(heights.rows, 5u);
  for (const char* symbol : {"z", "rx", "ry"}) ASSERT_NE(heights.find(symbol), nullptr) << symbol;
  // The robot lifts its plate by what its axes move together, within its 3 % of geometry.
  EXPECT_NEAR(heights.find("z")->values[1], 1, 0.05);
  EXPECT_NEAR(heights.find("z")->values[3], -2, 0.1);
  EXPECT_GT(std::hypot(heights.find("rx")->values[2], heights.find("ry")->values[2]), 600);
  EXPECT_NE(heights.find("plate_201"), nullptr) << "the voltages are on record";

  const auto level = cell.cli({"run", "start", plan, "--setup", "servo-level", "--watch"});
  ASSERT_EQ(level.code, 0) << level.err << cell.daemon_log();
  const auto tilts = data_of(cell, "2");
  ASSERT_EQ(tilts.rows, 5u);
  // Two instruments that share nothing but the scanner: 0.1 mV of noise are 1.4 arcsec of the level
  // and 0.6 arcsec of the plate; the robot repeats to its counts of 250 nm, 3 arcsec.
  for (std::size_t row = 0; row < 5; ++row)
    EXPECT_NEAR(tilts.find("rx")->values[row], heights.find("rx")->values[row], 15) << row;
  EXPECT_THAT(cell.cli({"status", "--json"}).out, HasSubstr("servo-level"));
  EXPECT_EQ(cell.stop_daemon(), 0);
}

TEST(AnalogueOnTheWire, ASensorBeyondItsRangeLeavesThePointWithoutItsCoordinates) {
  const LargerCell files("min-angle", kPlateAndLevel, kSensorsOfThePlant);
  RunningCell cell({.speed = 200,
                    .cell = files.name(),
                    .cellsim_options = {"--set", "emulator.scanner.slot2=7700"}});
  cell.edit_cell_file("max_spread_nm = 150.0", "max_spread_nm = 2000.0");
  cell.edit_cell_file("max_drift_nm_per_min = 500.0", "max_drift_nm_per_min = 5000.0");
  // At 2.2 mm of height the first sensor is at its end.
  cell.edit_cell_file(
      "zero_v = 5\nmin_v = 0.5\nmax_v = 9.5\nu = 0.0002\n[[device.sensor]]\ninput = 202",
      "zero_v = 5\nmin_v = 0.5\nmax_v = 5.9\nu = 0.0002\n[[device.sensor]]\ninput = 202");
  cell.start_daemon();
  const std::string plan = (fs::path(cell.folder()) / "heights.csv").string();
  write_file(plan, "q1_mm,q2_mm,q3_mm,zero\n0,0,0,1\n1,1,1,0\n3,3,3,0\n0,0,0,1\n");
  const auto run = cell.cli({"run", "start", plan, "--setup", "plate", "--watch"});
  ASSERT_EQ(run.code, 0) << run.err << cell.daemon_log();
  const auto data = data_of(cell, "1");
  ASSERT_EQ(data.rows, 4u) << "every point is accepted";
  EXPECT_NEAR(data.find("z")->values[1], 1, 0.05);
  for (const char* symbol : {"z", "rx", "ry"})
    EXPECT_TRUE(std::isnan(data.find(symbol)->values[2])) << symbol << ": beyond 1.8 mm";
  EXPECT_EQ(cell.stop_daemon(), 0);
}

TEST(AnalogueOnTheWire, ForcesJoinThePointsAndASecondAutocollimatorConfirms) {
  const LargerCell files("micro-nano", kForcesAndConfirmation, kForcesOfThePlant, kSeesRx,
                         kSeesRxAndRz);
  RunningCell cell({.speed = 100,
                    .cell = files.name(),
                    .cellsim_options = {"--set", "emulator.scanner.slot2=7700"}});
  cell.start_daemon();
  const std::string plan = (fs::path(cell.folder()) / "forces.csv").string();
  // Up and down again: the same place from both sides of the friction.
  write_file(plan,
             "q1_mm,q2_mm,q3_mm,force_N,zero,dwell_s\n0,0,0,0,1,10\n1,0,0,0,0,10\n"
             "1,0,0,2.305,0,10\n2,0,0,2.305,0,10\n1,0,0,2.305,0,10\n0,0,0,0,1,10\n");
  const auto run =
      cell.cli({"run", "start", plan, "--setup", "confirmed", "--watch"}, std::chrono::minutes(4));
  ASSERT_EQ(run.code, 0) << run.err << cell.daemon_log();
  const auto data = data_of(cell, "1");
  ASSERT_EQ(data.rows, 6u);
  const auto* beam = data.find("beam_force");
  const auto* motor = data.find("motor_force");
  const auto* band = data.find("motor_force_dead_band");
  ASSERT_TRUE(beam && motor && band && data.find("motor_force_u"));
  EXPECT_NEAR(beam->values[1], 0, 0.05);
  EXPECT_NEAR(beam->values[2], 2.305, 0.1) << "pulleys and weights of the plant";
  EXPECT_NEAR(motor->values[1], 2, 0.05) << "2 N/mm at 1 mm, reached upwards";
  EXPECT_NEAR(motor->values[3], 4, 0.05);
  EXPECT_NEAR(motor->values[4], 2, 0.05) << "reached downwards: the friction has turned round";
  EXPECT_EQ(band->values[4], 0);
  const auto* confirmed = data.find("rz_confirmed");
  const auto* difference = data.find("rz_difference");
  ASSERT_TRUE(confirmed && difference);
  for (std::size_t row = 0; row < data.rows; ++row)
    EXPECT_LT(std::abs(difference->values[row]), 0.5) << row;
  EXPECT_EQ(cell.stop_daemon(), 0);
}

}  // namespace
}  // namespace driftwise::tests
