// A robot's geometry as a model of a daemon: a robot file comes in, data judge it, it is promoted,
// and answers by gRPC and by the text line. Each answer is held against homogeneous matrices
// multiplied here.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/formats/cell_file/kinematics_section.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"
#include "tests/support/kinematics/arm_chain.h"

namespace driftwise::tests {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

KinematicsDescription drawn_ur10() {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/robots/ur10.toml");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  auto arm = *formats::parse_robot_file(text, "ur10.toml");
  for (auto& link : arm.links) link.min_deg = -360, link.max_deg = 360;
  return arm;
}

// Errors of the joints, as a diagnosis would have found them.
KinematicsDescription with_joint_errors(KinematicsDescription arm) {
  arm.links[1].errors.sag_urad_per_m = 1250;
  arm.links[2].errors.sag_urad_per_m = 740;
  arm.links[2].errors.gear_cos1_arcsec = 30;
  return arm;
}

// Of that arm as it was built and set up, points measured to 20 um.
std::string campaign_csv() {
  auto robot = with_joint_errors(drawn_ur10());
  robot.links[1].a_mm -= 1.1;
  robot.links[2].a_mm += 0.5;
  robot.links[3].d_mm += 0.3;
  robot.links[2].theta_deg += 0.05;
  robot.frame = {
      .x_mm = 900, .y_mm = -400, .z_mm = 120, .rx_deg = 0.4, .ry_deg = -0.3, .rz_deg = 40};
  return measured_csv(robot, 160);
}

class ArmModel : public testing::Test {
 protected:
  ArmModel() {
    cell.edit_cell_file(
        "kind = \"linear-axis\"\n\n[[kinematics.axis]]\nmotor = \"q1_mm\"\npose = \"x_mm\"\n",
        formats::write_robot_file(drawn_ur10()).substr(std::string("[kinematics]\n").size()));
    cell.start_daemon();
  }
  static std::string number_of(const nlohmann::json& made) {
    return std::to_string(made.at("model").at("id").get<int>());
  }
  std::string file_of(const std::string& name, const KinematicsDescription& arm) {
    return cell.write(name, formats::write_robot_file(arm));
  }
  // A pose of the model in the words of a request; the units are those of a target.
  static std::vector<std::string> words_of(const KinematicsDescription& arm,
                                           const std::vector<double>& q) {
    const auto tool = forward(arm, q, 20);
    const auto turns = rotations_arcsec(tool);
    std::vector<std::string> words;
    for (int k : {0, 1, 2}) words.push_back(fmt::format("{}_mm={}", "xyz"[k], tool(k, 3)));
    for (std::size_t k : {0, 1, 2})
      words.push_back(fmt::format("r{}_arcsec={}", "xyz"[k], turns[k]));
    return words;
  }
  static std::string near(const std::vector<double>& q, const char* before, const char* between) {
    std::string text;
    for (std::size_t j = 0; j < q.size(); ++j)
      text += fmt::format("{}{}q{}_rad={}", j == 0 ? "" : between, before, j + 1, q[j]);
    return text;
  }
  static void expect_reached(const KinematicsDescription& arm, const std::vector<double>& wanted,
                             const std::vector<double>& found) {
    ASSERT_EQ(found.size(), 6u);
    const auto there = forward(arm, wanted, 20), reached = forward(arm, found, 20);
    EXPECT_LT((there - reached).block(0, 3, 3, 1).norm() * 1e6, 1) << "nm";
  }
  std::vector<double> by_grpc(const KinematicsDescription& arm, const std::vector<double>& q,
                              const std::vector<double>& close) {
    auto command = words_of(arm, q);
    command.insert(command.begin(), "target");
    command.insert(command.end(), {"--near", near(close, "", ",")});
    std::vector<double> found;
    answer = cell.ask(command);
    for (const auto& one : answer.at("coordinates"))
      found.push_back(one.at("joint").at("position"));
    return found;
  }
  std::string line_of(const KinematicsDescription& arm, const std::vector<double>& q,
                      const std::vector<double>& close) {
    std::string line = "TARGET";
    for (const auto& word : words_of(arm, q)) line += " " + word;
    return line + " " + near(close, "near_", " ") + " u=1";
  }
  static std::vector<double> angles_in(const std::string& answered) {
    std::vector<double> found;
    for (int j = 1; j <= 6; ++j)
      if (const auto at = answered.find(fmt::format(" q{}_rad=", j)); at != std::string::npos)
        found.push_back(std::stod(answered.substr(at + 8)));
    return found;
  }

  CellAtWork cell;
  nlohmann::json answer;
};

const std::vector<double> kPosture = {0.3, -1.2, 1.4, -1.0, 1.1, 0.5};
const std::vector<double> kClose = {0.2, -1.1, 1.5, -0.9, 1.0, 0.7};

TEST_F(ArmModel, IsIdentifiedPromotedServedAndKeptOverARestart) {
  const auto drawing = file_of("found.toml", with_joint_errors(drawn_ur10()));
  const auto made =
      cell.ask({"model", "import", drawing, "--data", cell.write("tracker.csv", campaign_csv())});
  const std::string id = number_of(made);
  const auto shown = cell.ask({"model", "show", id});
  EXPECT_EQ(shown.at("kinematics").at("kind"), "serial-arm");
  EXPECT_EQ(shown.at("lineage").at("validation_row_count"), 40);
  // 20 um of each coordinate, held out.
  for (const auto& output : shown.at("outputs"))
    EXPECT_NEAR(output.at("accuracy").at("a90_validation_nm").get<double>(), 1.645 * 20'000,
                12'000);
  EXPECT_THAT(cell.say({"model", "show", id}), HasSubstr("link2.a_mm"));
  EXPECT_THAT(cell.say({"model", "list"}), HasSubstr("serial-arm, identified"));
  EXPECT_EQ(cell.refusal({"model", "export", id, "--format", "c"}).at("reason"), "BAD_FORMAT");
  const auto exported = nlohmann::json::parse(cell.say({"model", "export", id}));
  const auto robot =
      formats::parse_robot_file(exported.at("geometry").at("robot").get<std::string>(), "exported");
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_NEAR(robot->links[1].a_mm, -613.1, 0.1);  // as built

  cell.say({"model", "promote", id, "--yes"});
  expect_reached(*robot, kPosture, by_grpc(*robot, kPosture, kClose));
  EXPECT_THAT(answer.at("flags"), Not(Contains("unjudged_model")));
  // Some micrometres at a metre: seconds of arc.
  const double u = answer.at("coordinates").at(1).at("joint").at("u_arcsec");
  EXPECT_GT(u, 0.5);
  EXPECT_LT(u, 60);
  const auto line = line_of(*robot, kPosture, kClose);
  const auto answered = ask_line(cell.target_line_address(), line);
  EXPECT_THAT(answered, StartsWith("OK q1_rad="));
  EXPECT_THAT(answered, HasSubstr(" u90_q2_arcsec="));
  expect_reached(*robot, kPosture, angles_in(answered));

  cell.kill_daemon();
  cell.start_daemon();
  const auto again = ask_line(cell.target_line_address(), line);
  expect_reached(*robot, kPosture, angles_in(again));
  EXPECT_EQ(angles_in(again), angles_in(answered)) << again;
  EXPECT_THAT(cell.say({"model", "list"}), HasSubstr("serving"));
}

TEST_F(ArmModel, OfARobotFileAloneServesAndSaysThatNothingJudgedIt) {
  const auto robot = with_joint_errors(drawn_ur10());
  const auto made = cell.ask({"model", "import", file_of("found.toml", robot), "--name", "found"});
  const std::string id = number_of(made);
  EXPECT_THAT(cell.say({"model", "list"}), HasSubstr("found"));
  EXPECT_EQ(
      number_of(cell.ask({"model", "import", file_of("found.toml", robot), "--name", "found"})), id)
      << "the same again is the same model";
  cell.say({"model", "promote", id, "--yes"});
  expect_reached(robot, kPosture, by_grpc(robot, kPosture, kClose));
  EXPECT_THAT(answer.at("flags"), Contains("unjudged_model"));
  EXPECT_TRUE(answer.at("coordinates").at(0).at("joint").at("u_arcsec").is_null());
  const auto answered = ask_line(cell.target_line_address(), line_of(robot, kPosture, kClose));
  EXPECT_THAT(answered, HasSubstr("UNJUDGED_MODEL"));
  EXPECT_THAT(answered, Not(HasSubstr("u90_")));

  const std::vector<double> straight = {0.3, -1.2, 1.4, -1.0, 0.001, 0.5};
  EXPECT_THAT(ask_line(cell.target_line_address(), line_of(robot, straight, straight)),
              StartsWith("ERR NO_POSE(wrist) "));
  EXPECT_THAT(ask_line(cell.target_line_address(),
                       "TARGET x_mm=9000 y_mm=0 z_mm=0 rx_arcsec=0 ry_arcsec=0 rz_arcsec=0 " +
                           near(kClose, "near_", " ")),
              StartsWith("ERR NO_POSE no joint angles reach"));
  // No device of this cell reads the joints: what is nearest is not guessed.
  auto unsaid = words_of(robot, kPosture);
  unsaid.insert(unsaid.begin(), "target");
  EXPECT_EQ(cell.refusal(unsaid).at("reason"), "MISSING_VALUE");
  EXPECT_THAT(ask_line(cell.target_line_address(), "TARGET x_mm=1 near_q7=2"),
              StartsWith("ERR UNKNOWN_NAME"));
  EXPECT_EQ(cell.refusal({"model", "residuals", id}).at("reason"), "NO_FORMULA");
}

TEST_F(ArmModel, OfAnotherRobotIsRefusedWithASentence) {
  const auto refusal_of = [&](const KinematicsDescription& arm) {
    return cell.refusal({"model", "import", file_of("other.toml", arm)});
  };
  auto shorter = drawn_ur10();  // a UR5's upper arm
  shorter.links[1].a_mm = -425;
  auto refused = refusal_of(shorter);
  EXPECT_EQ(refused.at("reason"), "OTHER_ROBOT");
  EXPECT_THAT(refused.at("message").get<std::string>(), HasSubstr("link2.a_mm is -425"));
  auto fewer = drawn_ur10();
  fewer.links.pop_back();
  refused = refusal_of(fewer);
  EXPECT_EQ(refused.at("reason"), "OTHER_ROBOT");
  EXPECT_THAT(refused.at("message").get<std::string>(), HasSubstr("expected q1_rad"));
  KinematicsDescription axis;
  axis.kind = "linear-axis";
  axis.axes = {{{"q1", "mm"}, {"x", "mm"}}};
  EXPECT_THAT(refusal_of(axis).at("message").get<std::string>(),
              HasSubstr("found a linear-axis, expected a serial-arm"));
  EXPECT_EQ(cell.refusal({"model", "import", cell.write("no.toml", "[kinematics]\nkind = 1\n")})
                .at("reason"),
            "UNKNOWN_KIND");
  EXPECT_EQ(cell.count("SELECT count(*) FROM model"), 0);
}

}  // namespace
}  // namespace driftwise::tests
