// The predecessors' models on a file: fit --method, model compare FILE. No daemon is asked.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

const std::string kData =
    std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/ur10_laser_tracker/series_a_subset.csv";
const std::string kRobot = std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/robots/ur10.toml";

// Figures: tests/data/ur10_laser_tracker/identify.R.
TEST_F(CliTest, FitsARobotsOwnParametersToAFile) {
  const auto result =
      json({"fit", kData, "--method", "kinematic", "--kinematics", kRobot, "--blocks", "0"});
  EXPECT_EQ(result["schema"], "driftwise.method.v1");
  EXPECT_EQ(result["parameters"], 25);
  EXPECT_NEAR(result["position"]["rms_nm"].get<double>(), 431698.0202, 1e-3);
  bool seen = false;
  for (const auto& one : result["kinematics"]["parameters"]) {
    if (one["name"] == "link2.a_mm") {
      EXPECT_NEAR(one["value"].get<double>(), -613.107444, 5e-6);
    }
    if (one["name"] != "link1.d_mm") continue;
    seen = true;
    EXPECT_FALSE(one["free"].get<bool>());
    EXPECT_EQ(one["note"], "cannot be told apart from frame.z_mm");
    EXPECT_FALSE(one.contains("standard_error"));
  }
  EXPECT_TRUE(seen);
  const auto page =
      run({"fit", kData, "--method", "kinematic", "--kinematics", kRobot, "--blocks", "0"});
  EXPECT_THAT(page.out, HasSubstr("link2.a_mm"));
  EXPECT_THAT(page.out, HasSubstr("cannot be told apart from frame.z_mm"));
}

TEST_F(CliTest, AFitOfAFileWritesItsModelWithoutADaemon) {
  std::string data = "q1_mm,x_mm\n";
  for (int i = 0; i < 30; ++i) {
    const double x = 0.1 * i, noise = 1e-6 * (i * 7 % 11);
    data += std::to_string(1.0001 * x + noise) + "," + std::to_string(x) + "\n";
  }
  const auto table = file("line 1.csv", data);
  server.reset();
  const auto read_text = [](const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  };
  const auto as_c = folder.path() + "/model.c", as_json = folder.path() + "/model.json";
  EXPECT_EQ(run({"fit", table, "--model", "q ~ x", "-o", as_c, "--format", "c"}).exit, 0);
  EXPECT_THAT(read_text(as_c), HasSubstr("int driftwise_model_line_1("));
  EXPECT_EQ(run({"fit", table, "--model", "q ~ x", "-o", as_json}).exit, 0);
  EXPECT_EQ(nlohmann::json::parse(read_text(as_json)).at("schema"), "driftwise.model.v1");
}

TEST_F(CliTest, PutsMethodsSideBySide) {
  const auto result =
      json({"model", "compare", kData, "--kinematics", kRobot, "--methods", "nominal,kinematic",
            "--together", "line", "--folds", "3", "--blocks", "0"});
  EXPECT_EQ(result["schema"], "driftwise.comparison.v1");
  ASSERT_EQ(result["methods"].size(), 2U);
  EXPECT_NEAR(result["methods"][0]["position"]["rms_nm"].get<double>(), 4040476.4615, 1e-3);
  EXPECT_EQ(result["methods"][1]["rows"]["groups"], 207);
  EXPECT_LT(result["methods"][1]["position"]["rms_groups_nm"].get<double>(),
            0.2 * result["methods"][0]["position"]["rms_groups_nm"].get<double>());
  for (const auto& method : result["methods"]) EXPECT_TRUE(method["warnings"].empty());
}

TEST_F(CliTest, SaysWhatAMethodNeeds) {
  const auto no_drawing = run({"fit", kData, "--method", "kinematic"});
  EXPECT_EQ(no_drawing.exit, 3);
  EXPECT_THAT(no_drawing.err, HasSubstr("--kinematics robot.toml"));
  const auto no_formula = run({"fit", kData, "--method", "classic", "--kinematics", kRobot});
  EXPECT_EQ(no_formula.exit, 2);
  EXPECT_THAT(no_formula.err, HasSubstr("--model FORMULA"));
  const auto nothing = run({"model", "compare", kData});
  EXPECT_EQ(nothing.exit, 2);
  const auto two = run({"model", "compare", kData, "2"});
  EXPECT_EQ(two.exit, 2);
  EXPECT_THAT(two.err, HasSubstr("or one dataset file"));
  const auto at_daemon = run({"fit", "--run", "3", "--method", "nominal"});
  EXPECT_EQ(at_daemon.exit, 2);
  EXPECT_THAT(at_daemon.err, HasSubstr("works on a file only"));
}

}  // namespace
}  // namespace driftwise::tests
