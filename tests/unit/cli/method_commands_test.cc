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
  EXPECT_EQ(run({"fit", table, "--model", "q ~ x", "-o", as_json}).err, "wrote " + as_json + "\n");
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

// q1 follows t01; t02 is another thermometer beside it.
std::string warming_axis() {
  std::string csv = "time_s,q1_mm,x_mm,t01_degC,t02_degC\n";
  for (int row = 0; row < 80; ++row) {
    const double x = 0.05 * (row * 7 % 40), first = 20 + 0.02 * row + 0.01 * (row * 5 % 7),
                 second = 20 + 0.02 * row + 0.05 * (row * 3 % 5);
    csv += std::to_string(60 * row) + "," +
           std::to_string(x + 1e-3 * (first - 20) + 1e-6 * (row * 3 % 7)) + "," +
           std::to_string(x) + "," + std::to_string(first) + "," + std::to_string(second) + "\n";
  }
  return csv;
}

TEST_F(CliTest, TermsForcedAndLeftOutCountForEveryStudyOfAFile) {
  const auto data = file("warming.csv", warming_axis());
  const std::string formula = "q ~ x + T";
  const auto compared = [&](const std::vector<std::string>& more) {
    std::vector<std::string> line{"model", "compare", data, "--model", formula};
    line.insert(line.end(), more.begin(), more.end());
    return json(line)["methods"][0]["outputs"]["q1"]["a90_calibration_nm"].get<double>();
  };
  const double all = compared({}), without = compared({"--without", "t01"});
  EXPECT_GT(without, 5 * all) << "t01 carries the answer";
  EXPECT_NE(compared({"--without", "t01", "--without", "t02"}),
            compared({"--without", "t01", "--without", "t02", "--force", "x^2"}));
  const auto sensors = json({"model", "sensors", data, "--model", formula});
  const auto fewer = json({"model", "sensors", data, "--model", formula, "--without", "t01"});
  EXPECT_GT(fewer["sets"][0]["a90_blocks_rms_nm"].get<double>(),
            5 * sensors["sets"][0]["a90_blocks_rms_nm"].get<double>());
}

TEST_F(CliTest, ATermThatIsNotOfferedCannotBeLeftOut) {
  const auto data = file("warming.csv", warming_axis());
  for (const auto& line : std::vector<std::vector<std::string>>{
           {"fit", data}, {"model", "compare", data}, {"model", "sensors", data}}) {
    auto words = line;
    words.insert(words.end(), {"--model", "q ~ x + T", "--without", "x^2"});
    const auto said = run(words);
    EXPECT_EQ(said.exit, 3) << said.out;
    EXPECT_THAT(said.err, HasSubstr("--without x^2: the formula offers no such term"));
  }
}

TEST_F(CliTest, AnOptionThatACommandCannotUseIsRefused) {
  const auto data = file("warming.csv", warming_axis());
  const auto model = [&](std::vector<std::string> line) {
    line.insert(line.end(), {"--model", "q ~ x + T"});
    return run(line);
  };
  const auto residuals = folder.path() + "/r.csv";
  for (const auto& said :
       {model({"model", "compare", data, "--residuals", residuals}),
        model({"model", "sensors", data, "--history"}),
        model({"fit", kData, "--method", "classic", "--kinematics", kRobot, "--offers"}),
        model({"fit", data, "--format", "c"}), model({"fit", data, "--kinematics", kRobot})})
    EXPECT_EQ(said.exit, 2) << said.out;
  EXPECT_THAT(model({"model", "compare", data, "--residuals", residuals}).err,
              HasSubstr("--residuals is no option of model compare"));
  EXPECT_THAT(model({"fit", data, "--format", "c"}).err, HasSubstr("give -o FILE"));
}

}  // namespace
}  // namespace driftwise::tests
