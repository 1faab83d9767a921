// The whole loop on the wire: a cell that hides a mechanism in its plant, a daemon that knows
// nothing of it, `driftwise improve`, and the plant's private truth to judge by.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr auto kLong = std::chrono::seconds(170);

// Positions up and down over the stroke, so that the direction of approach takes both values.
std::string up_and_down(int lines) {
  std::string csv = "q1_mm,set,line,zero\n";
  for (int line = 1; line <= lines; ++line) {
    csv += "0,calibration," + std::to_string(line) + ",1\n";
    for (int i = 0; i < 8; ++i) {
      const int step = line % 2 == 1 ? i : 7 - i;
      const double q_mm = -3.7 + step * 1.03 + 0.013 * line;
      csv += std::to_string(q_mm) + "," + (i % 3 == 2 ? "validation" : "calibration") + "," +
             std::to_string(line) + ",0\n";
    }
  }
  return csv;
}

// A joint bends under the guide's friction: what the approach from below and from above differ by.
TEST(Improve, FindsTheFrictionThatThePlantHidesAndLowersTheErrorOnFreshPoints) {
  CellAtWork cell({.speed = 400,
                   .seed = 3,
                   .cellsim_options = {"--set",
                                       "hidden.guide={kind=\"friction\",axis=1,friction_n=1.0,"
                                       "stiffness_n_um=5.0,presliding_um=1.0}"}});
  // The zero is approached from both sides: its play is larger than what a length may jump by.
  cell.edit_cell_file("[kinematics]", "[plausibility]\nclosure_nm = 2000\n\n[kinematics]");
  cell.start_daemon();
  const auto plan = cell.write("plan.csv", up_and_down(14));
  const auto done = cell.cli({"improve", plan, "--model", "q ~ poly(x, 3) + T", "--max-turns", "2",
                              "--timeout", "170", "--json"},
                             kLong);
  ASSERT_EQ(done.code, 0) << done.err << cell.daemon_log();
  const auto improvement = json::parse(done.out);
  EXPECT_EQ(improvement.at("state"), "done") << improvement.dump(2);
  const auto& turn = improvement.at("turns").at(0);
  const auto diagnosis =
      cell.ask({"diagnosis", "show", std::to_string(turn.at("diagnosis_id").get<int>())});
  ASSERT_FALSE(diagnosis.at("findings").empty()) << diagnosis.dump(2);
  EXPECT_EQ(diagnosis.at("findings").at(0).at("cause"), "backlash") << turn.dump(2);
  const auto& gain = turn.at("gains").at(0);
  // The play goes; the mean of the fresh run, whose zero is another, stays with both models.
  EXPECT_LT(gain.at("measured").at("u90").get<double>(),
            0.5 * gain.at("measured_before").at("u90").get<double>())
      << turn.dump(2);
  EXPECT_LT(gain.at("measured").at("a90").get<double>(),
            gain.at("measured_before").at("a90").get<double>())
      << turn.dump(2);
  EXPECT_EQ(cell.events("improvement.done"), 1);
  // Each turn measures anew: the second may find more than noise, or nothing.
  const auto accepted = cell.events("extension.accepted");
  EXPECT_GE(accepted, 1);
  EXPECT_LE(accepted, static_cast<int>(improvement.at("turns").size()));
}

TEST(Improve, ADaemonThatIsKilledMeanwhileKeepsTheRunAndSaysThatTheLoopFailed) {
  CellAtWork cell({.speed = 400});
  cell.start_daemon();
  const auto plan = cell.write("plan.csv", up_and_down(30));
  auto loop = cell.cli_process({"improve", plan, "--model", "q ~ x"});
  cell.wait_for_points(3);
  cell.kill_daemon();
  cell.start_daemon();
  const auto improvement = cell.ask({"improve", "list"}).at("improvements").at(0);
  EXPECT_EQ(improvement.at("state"), "failed");
  EXPECT_THAT(improvement.at("reason").get<std::string>(), HasSubstr("the daemon ended"));
  EXPECT_GE(cell.run(1).at("accepted_count").get<int>(), 3);
  cell.say({"run", "abort", "1"});
}

}  // namespace
}  // namespace driftwise::tests
