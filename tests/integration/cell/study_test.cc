// Methods side by side and the choice of thermometers, of a run at the daemon and of the file it
// exports: the same engine, so the same figures to the last digit.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

constexpr const char* kAxisFile =
    "[kinematics]\nkind = \"linear-axis\"\n[[kinematics.axis]]\nmotor = \"q1_mm\"\npose = "
    "\"x_mm\"\n";

// The stopwatch is no figure.
nlohmann::json without_times(nlohmann::json comparison) {
  for (auto& method : comparison.at("methods")) {
    method.erase("fit_us");
    if (method.contains("fit")) method.at("fit").erase("fit_us");
  }
  return comparison;
}

TEST(Studies, OfARunAreThoseOfTheFileThatItExports) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(8, 6))).at("state"), "done");
  const auto csv = cell.folder() + "/run.csv";
  cell.say({"data", "export", "1", "-o", csv});
  const auto robot = cell.write("robot.toml", kAxisFile);

  const std::vector<std::string> sensors = {"--model", "q ~ x + t05 + t06 + t07", "--blocks", "4"};
  auto of_run = std::vector<std::string>{"model", "sensors", "--run", "1", "--threads", "2"};
  auto of_file = std::vector<std::string>{"model", "sensors", csv};
  of_run.insert(of_run.end(), sensors.begin(), sensors.end());
  of_file.insert(of_file.end(), sensors.begin(), sensors.end());
  const auto run = cell.ask(of_run), file = cell.ask(of_file);
  EXPECT_EQ(run.at("sets_tried"), 8);
  EXPECT_EQ(run.at("recommended"), file.at("recommended"));
  for (std::size_t i = 0; i < file.at("sets").size(); ++i) {
    EXPECT_EQ(run.at("sets").at(i).at("sensors"), file.at("sets").at(i).at("sensors"));
    EXPECT_EQ(run.at("sets").at(i).at("u90_blocks_rms_nm"),
              file.at("sets").at(i).at("u90_blocks_rms_nm"));
  }

  const std::vector<std::string> methods = {"--kinematics", robot, "--model",    "q ~ x + t05",
                                            "--blocks",     "4",   "--together", "line",
                                            "--folds",      "3"};
  of_run = {"model", "compare", "--run", "1"};
  of_file = {"model", "compare", csv};
  of_run.insert(of_run.end(), methods.begin(), methods.end());
  of_file.insert(of_file.end(), methods.begin(), methods.end());
  const auto compared = cell.ask(of_run);
  EXPECT_EQ(compared.at("methods").size(), 4u);
  const auto figures = [](const nlohmann::json& comparison) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& method : comparison.at("methods"))
      all.push_back({method.at("method"), method.at("parameters"), method.at("outputs")});
    return all;
  };
  EXPECT_EQ(figures(without_times(compared)), figures(without_times(cell.ask(of_file))));
}

TEST(Studies, WhatTheNewVerbsSayOfARun) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(4, 6))).at("state"), "done");
  const auto check = cell.ask({"formula", "check", "q ~ x + x^2 + t05", "--run", "1"});
  EXPECT_EQ(check.at("problem"), "");
  EXPECT_EQ(check.at("column_count"), 4);
  EXPECT_EQ(cell.cli({"formula", "check", "q ~ x + to5", "--run", "1"}).code, 1);
  const auto fit = cell.ask({"fit", "--run", "1", "--model", "q ~ x", "--threads", "2"});
  const auto model = std::to_string(fit.at("model_id").get<int>());
  EXPECT_EQ(cell.ask({"fit", "--run", "1", "--model", "q ~ x"}).at("model_id"), fit.at("model_id"))
      << "one thread gives the same model";
  const auto left = cell.ask({"model", "residuals", model});
  EXPECT_TRUE(left.at("same_rows").get<bool>());
  EXPECT_EQ(left.at("row_count"), 24);
  EXPECT_THAT(cell.say({"model", "residuals", model}), testing::HasSubstr("q1_residual_nm"));
  cell.say({"model", "promote", model, "--yes"});
  const auto map = cell.ask({"target", "map", "--axis", "x=-2:2:5", "--axis", "force=0:1:2"});
  EXPECT_EQ(map.at("planes").at(0).at("position_mm").size(), 10u);
}

}  // namespace
}  // namespace driftwise::tests
