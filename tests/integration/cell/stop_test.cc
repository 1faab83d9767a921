// Stop pressed while the controller's connection is down, on the wire: issue 11, number 13.

#include <gmock/gmock.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

double true_axis_mm(const CellAtWork& cell) {
  const auto answer = cell.control("truth?");
  const auto truth = nlohmann::json::parse(answer.substr(answer.find('{')));
  return truth.at("end_effector_nm").get<double>() * 1e-6;
}

// A slow axis that is on its way from -4 to 4 mm within a run: eight seconds of real time.
class StopOnTheWire : public testing::Test {
 protected:
  StopOnTheWire() : cell({.speed = 100}) {
    cell.edit_cell_file("velocity_mm_s = 5.0", "velocity_mm_s = 0.01");
    cell.edit_cell_file("move_timeout_s = 30.0", "move_timeout_s = 2000.0");
    cell.start_daemon();
    run = cell.start_run(
        "q1_mm,set,line,zero\n0,calibration,1,1\n-4,calibration,1,0\n"
        "4,calibration,1,0\n0,calibration,1,0\n");
    cell.wait_for_points(2);
    wait_until("the axis is on its way", [this] { return true_axis_mm(cell) > -3.9; });
  }
  void expect_not_confirmed() {
    grpc::ClientContext context;
    v1::StopAllResponse answer;
    const auto before = std::chrono::steady_clock::now();
    const auto status = v1::CellService::NewStub(cell.channel())->StopAll(&context, {}, &answer);
    const auto took = std::chrono::steady_clock::now() - before;
    ASSERT_TRUE(status.ok()) << status.error_message();
    // 100 ms on a machine that is free; this one may be busy.
    EXPECT_LT(took, std::chrono::seconds(1));
    EXPECT_FALSE(answer.confirmed());
    EXPECT_THAT(answer.message(), HasSubstr("not confirmed: use the emergency switch"));
    ASSERT_EQ(answer.pending_size(), 1);
    EXPECT_EQ(answer.pending(0).device_id(), "axis");
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
    std::this_thread::sleep_for(
        std::chrono::seconds(1));  // 100 s of the cell: a millimetre of a move
    EXPECT_NEAR(true_axis_mm(cell), here_mm, 0.01);
    EXPECT_EQ(cell.state_of(run), "paused");
  }
  CellAtWork cell;
  std::int64_t run = 0;
};

TEST_F(StopOnTheWire, TheAxisDoesNotGoOnWhenTheConnectionIsBack) {
  cell.control("fault drop axis for 200 s");  // two seconds of real time
  expect_not_confirmed();
  expect_halted_for_good();
  EXPECT_EQ(cell.events("stop.unconfirmed"), 1);
  EXPECT_EQ(cell.events("stop.confirmed"), 1);
  EXPECT_EQ(cell.count("SELECT count(*) FROM alarm WHERE kind = 'stop.unconfirmed'"), 1);
}

TEST_F(StopOnTheWire, AKillWithAPendingStopChangesNothing) {
  cell.control("fault drop axis for 200 s");
  expect_not_confirmed();
  cell.kill_daemon();
  cell.start_daemon();
  expect_halted_for_good();
  EXPECT_EQ(cell.events("axes.home"), 0);
}

// Asked for while the daemon was dead: the start is not what makes the robot go on.
TEST_F(StopOnTheWire, AStopWithoutADaemonIsTheFirstThingThatTheNextOneDoes) {
  cell.kill_daemon();
  const auto stop =
      run_process({"sh", "-c",
                   "cd '" + cell.folder() +
                       "' && '" DRIFTWISE_BUILD_FOLDER "/bin/driftwise' stop --operator ada"},
                  std::chrono::seconds(30));
  EXPECT_EQ(stop.code, 4);
  EXPECT_THAT(stop.err, HasSubstr("NOT STOPPED: use the emergency switch"));
  cell.start_daemon();
  expect_halted_for_good();
  EXPECT_EQ(cell.events("stop.kept"), 1);
  EXPECT_EQ(cell.events("axes.home"), 0);
  EXPECT_EQ(cell.run(run).at("hold").at("who"), "ada");
  cell.kill_daemon();
  cell.start_daemon();
  EXPECT_EQ(cell.events("stop.kept"), 1) << "it is kept once";
}

// A client that wrote it while the daemon started, or hung.
TEST_F(StopOnTheWire, AStopThatWasKeptIsTakenByADaemonThatRuns) {
  cell.write("driftwised.stop", R"({"who": "bob", "asked": "2026-11-28T19:43:00Z"})");
  expect_halted_for_good();
  EXPECT_EQ(cell.run(run).at("hold").at("who"), "bob");
  EXPECT_FALSE(std::filesystem::exists(cell.folder() + "/driftwised.stop"));
}

// A restored copy that somebody looks at beside the cell, and the cell's own record.
TEST_F(StopOnTheWire, AStopOfARecordIsOfItsOwnNextStart) {
  const std::string stop = R"({"who": "the restore of x.db by root", "asked": ""})";
  const std::string other = cell.folder() + "/look.db.stop", own = cell.database() + ".stop";
  for (const auto& path : {other, own}) std::ofstream(path) << stop;
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));  // two looks of the daemon
  EXPECT_NE(cell.state_of(run), "paused");
  EXPECT_EQ(cell.events("stop"), 0);
  cell.kill_daemon();
  cell.start_daemon();
  expect_halted_for_good();
  EXPECT_EQ(cell.run(run).at("hold").at("who"), "the restore of x.db by root");
  EXPECT_FALSE(std::filesystem::exists(own));
  EXPECT_TRUE(std::filesystem::exists(other));
}

}  // namespace
}  // namespace driftwise::tests
