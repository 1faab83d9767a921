// Stop pressed while the controller's connection is down, on the wire: issue 11, number 13.

#include <gmock/gmock.h>

#include <cmath>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

double true_axis_mm(const CellAtWork& cell) {
  const auto answer = cell.control("truth?");
  const auto truth = nlohmann::json::parse(answer.substr(answer.find('{')));
  return truth.at("end_effector_nm").get<double>() * 1e-6;
}

// A slow axis that is on its way from -4 to 4 mm within a run.
class StopOnTheWire : public testing::Test {
 protected:
  StopOnTheWire() : cell({.speed = 20}) {
    cell.edit_cell_file("velocity_mm_s = 5.0", "velocity_mm_s = 0.2");
    cell.edit_cell_file("move_timeout_s = 30.0", "move_timeout_s = 300.0");
    cell.start_daemon();
    run = cell.start_run(
        "q1_mm,set,line,zero\n0,calibration,1,1\n-4,calibration,1,0\n"
        "4,calibration,1,0\n0,calibration,1,0\n");
    cell.wait_for_points(2);
    wait_until("the axis is on its way", [this] { return true_axis_mm(cell) > -3.5; });
  }
  void expect_not_confirmed() {
    const auto before = std::chrono::steady_clock::now();
    const auto said = cell.refusal({"stop"});
    // With the start of the command line's process.
    EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
    EXPECT_EQ(said.at("reason"), "STOP_NOT_CONFIRMED");
    EXPECT_THAT(said.at("message"), HasSubstr("use the emergency switch"));
    EXPECT_EQ(cell.count("SELECT count(*) FROM stop WHERE confirmed_ns = 0"), 1);
  }
  // It halted on its way, and stays there.
  void expect_halted_for_good() {
    wait_until("the controller has confirmed", [this] {
      return cell.count("SELECT count(*) FROM stop WHERE confirmed_ns = 0") == 0;
    });
    wait_until("the run is paused", [this] { return cell.state_of(run) == "paused"; });
    const double here_mm = true_axis_mm(cell);
    EXPECT_LT(here_mm, 3.9);
    std::this_thread::sleep_for(std::chrono::seconds(1));  // 20 s of the cell: 4 mm of a move
    EXPECT_NEAR(true_axis_mm(cell), here_mm, 0.01);
    EXPECT_EQ(cell.state_of(run), "paused");
  }
  CellAtWork cell;
  std::int64_t run = 0;
};

TEST_F(StopOnTheWire, TheAxisDoesNotGoOnWhenTheConnectionIsBack) {
  cell.control("fault drop axis for 10 s");  // half a second of real time
  expect_not_confirmed();
  EXPECT_EQ(cell.refusal({"run", "resume", std::to_string(run)}).at("reason"), "STOP_PENDING");
  expect_halted_for_good();
  EXPECT_EQ(cell.events("stop.unconfirmed"), 1);
  EXPECT_EQ(cell.events("stop.confirmed"), 1);
  EXPECT_EQ(cell.count("SELECT count(*) FROM alarm WHERE kind = 'stop.unconfirmed'"), 1);
  cell.say({"run", "resume", std::to_string(run)});
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
}

TEST_F(StopOnTheWire, AKillWithAPendingStopChangesNothing) {
  cell.control("fault drop axis for 8 s");
  expect_not_confirmed();
  cell.kill_daemon();
  cell.start_daemon();
  expect_halted_for_good();
  EXPECT_EQ(cell.events("axes.home"), 0);
}

}  // namespace
}  // namespace driftwise::tests
