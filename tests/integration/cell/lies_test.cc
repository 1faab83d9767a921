// A device that lies over its wire: one channel of each kind of device. It is found, joins no point
// unmarked, and the run goes on when it says the truth again.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

class LiesOnTheWire : public testing::Test {
 protected:
  void expect_found(CellAtWork& cell, const std::string& lie, const std::string& event,
                    const std::string& trajectory) {
    cell.start_daemon();
    const auto run = cell.start_run(trajectory);
    cell.wait_for_points(5);
    const auto before = cell.events(event);
    ASSERT_THAT(cell.control("fault lie " + lie), testing::HasSubstr("OK"));
    wait_until(lie + " is found as " + event, [&] { return cell.events(event) > before; });
    wait_until("an alarm stands", [&] {
      return cell.count("SELECT count(*) FROM alarm WHERE kind = '" + event + "'") > 0;
    });
    cell.control("fault clear");
    const auto ended = cell.end_of(run);
    EXPECT_EQ(ended.at("state"), "done") << ended << cell.daemon_log();
  }
};

TEST_F(LiesOnTheWire, AnInterferometerThatJumps) {
  CellAtWork cell;
  expect_found(cell, "laser-x jump 100000", "pose.disagrees", campaign(6, 6));
  EXPECT_EQ(cell.count("SELECT count(*) FROM point_wide WHERE abs(x_mm - q1_mm) > 0.05"), 0);
}
TEST_F(LiesOnTheWire, AnInterferometerThatFreezes) {
  CellAtWork cell;
  expect_found(cell, "laser-x constant", "reading.frozen", campaign(6, 6));
}
TEST_F(LiesOnTheWire, AnAxisWhoseReadbackIsElsewhere) {
  CellAtWork cell;
  expect_found(cell, "axis jump 40", "reading.range", campaign(6, 6));
}
TEST_F(LiesOnTheWire, AThermometerThatStepsByFiveKelvin) {
  CellAtWork cell;
  expect_found(cell, "scanner jump 20", "reading.step", campaign(6, 6));
  EXPECT_EQ(cell.count("SELECT count(*) FROM point_wide WHERE t01_degC > 23"), 0);
  EXPECT_GE(cell.count("SELECT count(*) FROM rejected_reading WHERE channel = 't01_degC'"), 1);
}
// 500 degC are beyond the multimeter's range: it says that it has no value.
TEST_F(LiesOnTheWire, AThermometerBeyondTheScannersRange) {
  CellAtWork cell;
  expect_found(cell, "scanner value 2800", "reading.missing", campaign(6, 6));
}
TEST_F(LiesOnTheWire, AStabiliserThatSteps) {
  CellAtWork cell;
  expect_found(cell, "support jump 5", "reading.step", campaign(6, 6));
}

// Lines of three points and their return to zero, on three axes.
std::string lines_of_three_axes(int lines) {
  std::string csv = "q1_mm,q2_mm,q3_mm,set,line,zero,force_N\n";
  for (int line = 1; line <= lines; ++line) {
    const std::string end = "," + std::to_string(line) + ",";
    for (const char* place :
         {"0.5,0.5,1,calibration", "1,0.5,0.5,validation", "0.5,1,1,calibration"})
      csv += place + end + "0,0\n";
    csv += "0,0,0,calibration" + end + "1,0\n";
  }
  return csv;
}

TEST_F(LiesOnTheWire, AnAutocollimatorThatJumps) {
  CellAtWork cell({.speed = 200, .cell = "micro-nano"});
  expect_found(cell, "collimator-1 jump 20", "closure.bad", lines_of_three_axes(6));
  EXPECT_GE(cell.count("SELECT count(*) FROM suspect_point"), 1);
}
TEST_F(LiesOnTheWire, ALoadThatSaysAnotherForce) {
  CellAtWork cell({.speed = 200, .cell = "micro-nano"});
  expect_found(cell, "load jump 0.1", "reading.step", lines_of_three_axes(6));
}

}  // namespace
}  // namespace driftwise::tests
