// A touch probe beside an interferometer that gives the same coordinate, on the wire:
// driftwise-cellsim, driftwised and the record.

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "server/formats/csv/dataset_csv.h"
#include "tests/support/running_cell.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

TEST(TouchProbeOnTheWire, MeasuresInItsSetUpAndHasNoLengthWhereItTouchesNothing) {
  RunningCell cell(
      {.speed = 200, .cell = "min-angle", .cellsim_options = {"--set", "touch_probe.range_mm=2"}});
  cell.start_daemon();
  const std::string plan = (std::filesystem::path(cell.folder()) / "heights.csv").string();
  write_file(plan, "q1_mm,q2_mm,q3_mm,zero\n0,0,0,1\n1,1,1,0\n3,3,3,0\n-1,-1,-1,0\n0,0,0,1\n");

  const auto neither = cell.cli({"run", "start", plan});
  EXPECT_NE(neither.code, 0);
  EXPECT_THAT(neither.err, HasSubstr("z_mm is given by 'laser-z' and by 'touch'"));

  const auto run = cell.cli({"run", "start", plan, "--setup", "probe", "--watch"});
  ASSERT_EQ(run.code, 0) << run.err << cell.daemon_log();
  const auto data = formats::read_dataset_csv(cell.cli({"data", "export", "1"}).out, "export");
  ASSERT_TRUE(data) << data.error().message;
  ASSERT_EQ(data->rows, 5u);
  const auto* z_mm = data->find("z");
  ASSERT_NE(z_mm, nullptr);
  // The hysteresis of the tip, and its axis that leans by a degree.
  EXPECT_NEAR(z_mm->values[1], 1, 0.003);
  EXPECT_TRUE(std::isnan(z_mm->values[2])) << "beyond the end of its way";
  EXPECT_NEAR(z_mm->values[3], -1, 0.003);
  EXPECT_THAT(cell.cli({"status", "--json"}).out, HasSubstr("ND 287, 349797-05, V1.02"));
  EXPECT_EQ(cell.stop_daemon(), 0);
}

}  // namespace
}  // namespace driftwise::tests
