// A held button on the wire: the client vanishes, and the axis is stopped by the wall clock,
// however fast the cell's own runs. Through the driver and the controller's emulator.

#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

double true_position_mm(const CellAtWork& cell) {
  const auto answer = cell.control("truth?");
  const auto truth = nlohmann::json::parse(answer.substr(answer.find('{')));
  return truth.at("end_effector_nm").get<double>() * 1e-6;
}

// A slow axis: a step of 1 mm takes five seconds of real time.
class JogOnTheWire : public testing::Test {
 protected:
  JogOnTheWire() : cell({.speed = 20}) {
    cell.edit_cell_file("velocity_mm_s = 5.0", "velocity_mm_s = 0.01");
    cell.edit_cell_file("move_timeout_s = 30.0", "move_timeout_s = 2000.0");
    cell.start_daemon();
    cell.say({"home", "--yes"});
    before_mm = true_position_mm(cell);
  }
  Process held_by_a_client() {
    auto client = cell.cli_process({"jog", "q1", "+1", "--hold", "60"});
    wait_until("the axis is on its way",
               [this] { return true_position_mm(cell) > before_mm + 0.05; });
    return client;
  }
  void expect_stopped_on_its_way() {
    wait_until("the silence is on record", [this] { return cell.events("axes.jog_lost") == 1; });
    const double here_mm = true_position_mm(cell);
    EXPECT_LT(here_mm, before_mm + 0.9) << "it did not reach the end of its step";
    std::this_thread::sleep_for(std::chrono::seconds(1));  // 0.2 mm of a movement that goes on
    EXPECT_NEAR(true_position_mm(cell), here_mm, 0.001);
    EXPECT_EQ(cell.count("SELECT count(*) FROM stop WHERE confirmed_ns = 0"), 0);
  }
  CellAtWork cell;
  double before_mm = 0;
};

TEST_F(JogOnTheWire, AClientThatIsKilledLeavesAnAxisAtRest) {
  auto client = held_by_a_client();
  client.signal(SIGKILL);
  expect_stopped_on_its_way();
}

// The connection stays open and nothing comes through it: a cable that was pulled.
TEST_F(JogOnTheWire, AClientThatFallsSilentLeavesAnAxisAtRest) {
  auto client = held_by_a_client();
  client.signal(SIGSTOP);
  expect_stopped_on_its_way();
  client.signal(SIGCONT);
}

TEST_F(JogOnTheWire, AButtonThatIsLetGoStopsTheAxis) {
  const auto jog = cell.ask({"jog", "q1", "+1", "--hold", "0.5"});
  EXPECT_TRUE(jog.at("released").get<bool>());
  EXPECT_EQ(cell.events("axes.jog_lost"), 0);
  EXPECT_LT(true_position_mm(cell), before_mm + 0.9);
  const auto step = cell.ask({"jog", "q1", "+0.001"});
  EXPECT_EQ(step.at("step_count"), 1);
  EXPECT_THAT(cell.refusal({"jog", "q1", "+2"}).at("reason"), "BAD_STEP");
}

TEST_F(JogOnTheWire, TheCellIsCheckedAgainstItsFile) {
  const auto check = cell.ask({"cell", "check"});
  bool light = false;
  for (const auto& item : check.at("items")) {
    EXPECT_NE(item.at("verdict"), "bad") << item;
    light = light || item.at("asked") == "light level";
  }
  EXPECT_TRUE(light);
  EXPECT_THAT(cell.say({"cell", "check"}), HasSubstr("with nothing declared to compare with"));
}

}  // namespace
}  // namespace driftwise::tests
