// `target --kinematics` of a serial arm: no daemon is asked.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class ArmTargetCommand : public CliTest {
 protected:
  void SetUp() override {}  // without a daemon

  // Three joints of which the last drifts by 3 arcsec per kelvin from 21.66 degC.
  std::string robot(const std::string& thermometer) {
    const auto link = [](const std::string& motor, int d_mm, int a_mm, int alpha_deg) {
      return "[[kinematics.link]]\nmotor = \"" + motor + "\"\nd_mm = " + std::to_string(d_mm) +
             "\na_mm = " + std::to_string(a_mm) + "\nalpha_deg = " + std::to_string(alpha_deg) +
             "\n";
    };
    return file("robot_" + thermometer + ".toml",
                "[kinematics]\nkind = \"serial-arm\"\n" + link("q1_deg", 300, 0, 90) +
                    link("q2_deg", 0, 500, 0) + link("q3_deg", 0, 400, 0) + "drift_channel = \"" +
                    thermometer + "\"\ndrift_arcsec_per_k = 3\ndrift_from_degC = 21.66\n");
  }
  Outcome ask(const std::string& thermometer, std::vector<std::string> words) {
    std::vector<std::string> line = {"target", "--kinematics", robot(thermometer)};
    line.insert(line.end(), words.begin(), words.end());
    return run(line);
  }
  double third_joint_deg(const std::string& thermometer, const std::string& temperature) {
    const auto asked = ask(thermometer, {"x=500", "y=100", "z=600", temperature, "--json"});
    EXPECT_EQ(asked.exit, 0) << asked.err;
    return nlohmann::json::parse(asked.out).at("joints").at("q3_deg").get<double>();
  }
};

TEST_F(ArmTargetCommand, ReadsATemperatureInTheUnitOfTheRobotFileOrInItsOwn) {
  const double expected = third_joint_deg("t05_degC", "t05=31.66");
  for (const auto& [thermometer, temperature] : {std::pair{"t05_degC", "t05_K=304.81"},
                                                 {"t05_K", "t05=304.81"},
                                                 {"t05_K", "t05_K=304.81"},
                                                 {"t05_K", "t05_degC=31.66"}})
    EXPECT_NEAR(third_joint_deg(thermometer, temperature), expected, 1e-9) << temperature;
  // The drift of 10 K is turned back.
  EXPECT_NEAR(third_joint_deg("t05_K", "t05=294.81") - expected, 30.0 / 3600, 1e-9);
  const auto celsius = ask("t05_K", {"x=500", "y=100", "z=600", "t05=21.66"});
  EXPECT_EQ(celsius.exit, 2);
  EXPECT_THAT(celsius.err, HasSubstr("found 't05=21.66', which is -251.49 degC"));
  EXPECT_THAT(celsius.err, HasSubstr("t05_degC=23.1"));
}

TEST_F(ArmTargetCommand, RefusesWordsThatItDoesNotUnderstand) {
  struct Row {
    std::vector<std::string> more;
    const char* sentence;
  };
  for (const Row& row :
       {Row{{"x=600"}, "found 'x=500' and 'x=600', expected x once"},
        Row{{"t05_K=300"}, "found 't05=22' and 't05_K=300', expected t05 once"},
        Row{{"w=3"}, "found 'w=3', expected x, y, z (mm), t05 (degC)"},
        Row{{"t4=3"}, "found 't4=3'"}, Row{{"force=5"}, "found 'force=5'"},
        Row{{"rz=1"}, "found 'rz=1'"},
        Row{{"--near", "q1=1,q1=2"}, "--near: found 'q1=1' and 'q1=2', expected q1 once"},
        Row{{"--near", "q1_deg=1,q1_rad=2"}, "found 'q1_deg=1' and 'q1_rad=2'"},
        Row{{"--near", "q4=1"}, "--near: found 'q4=1', expected joints q1 to q3"},
        Row{{"--near", "q1_deg=1e15"}, "found 'q1_deg=1e15', expected an angle from -1000000"},
        Row{{"--budget"}, "--budget asks the daemon"},
        Row{{"--watch"}, "--watch asks the daemon"}}) {
    std::vector<std::string> words = {"x=500", "y=100", "z=600", "t05=22"};
    words.insert(words.end(), row.more.begin(), row.more.end());
    const auto outcome = ask("t05_degC", words);
    EXPECT_EQ(outcome.exit, 2) << row.sentence;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr(row.sentence));
  }
}

TEST_F(ArmTargetCommand, AnswersNearTheLargestAngleThatItTakes) {
  const auto far =
      ask("t05_degC", {"x=500", "y=100", "z=600", "t05=22", "--near", "q1_deg=1e6", "--json"});
  EXPECT_EQ(far.exit, 0) << far.err;
  EXPECT_LE(nlohmann::json::parse(far.out).at("miss_nm").get<double>(), 1);
}

}  // namespace
}  // namespace driftwise::tests
