// Hald's cement data (Draper and Smith; tests/data/nist_strd/hald_expected.csv): the two published
// stepwise paths.

#include <gmock/gmock.h>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

using testing::ElementsAre;

Model fit_hald(double p_enter) {
  FitOptions options;
  options.p_enter = p_enter;
  options.blocks = 0;
  const auto model = formats::fit_formula(dataset_of(read_rows("nist_strd/hald.csv")),
                                          "heat ~ x1 + x2 + x3 + x4", options);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return *model;
}

std::vector<std::string> path(const OutputModel& output) {
  std::vector<std::string> steps;
  for (const auto& step : output.history)
    if (step.action != "start") steps.push_back(step.action + " " + effects::notation(step.term));
  return steps;
}

// Rows of hald_expected.csv for one final model.
void expect_terms(const OutputModel& output, const std::string& model) {
  int found = 0;
  for (const auto& row : read_rows("nist_strd/hald_expected.csv")) {
    if (row[0] != model) continue;
    if (row[1] == "rmse") {
      EXPECT_NEAR(output.accuracy.rmse, std::stod(row[2]), 1e-11);
      continue;
    }
    const bool in = row[1].front() != '(';
    const std::string name = row[1] == "const" ? "1" : in ? row[1] : row[1].substr(1, 2);
    for (const auto& report : output.report) {
      if (effects::notation(report.term) != name) continue;
      ++found;
      EXPECT_EQ(report.in, in) << name;
      const double tolerance = in ? 1e-11 : 1e-6;  // the file gives 12 and 8 digits
      EXPECT_NEAR(report.coefficient / std::stod(row[2]), 1, tolerance) << name;
      EXPECT_NEAR(report.standard_error / std::stod(row[3]), 1, tolerance) << name;
      EXPECT_NEAR(report.t / std::stod(row[4]), 1, tolerance) << name;
      EXPECT_NEAR(report.p / std::stod(row[5]), 1, 10 * tolerance) << name;
    }
  }
  EXPECT_GE(found, 3);
}

TEST(Hald, EntersX4ThenX1AtTheUsualThresholds) {
  const Model model = fit_hald(0.05);
  EXPECT_THAT(path(model.outputs[0]), ElementsAre("enter x4", "enter x1"));
  EXPECT_NEAR(model.outputs[0].history[1].p, 5.762318e-4, 1e-10);
  EXPECT_NEAR(model.outputs[0].history[2].p, 1.105281e-6, 1e-12);
  expect_terms(model.outputs[0], "x1+x4");
}

TEST(Hald, RemovesX4AgainWhenX2MayEnter) {
  const Model model = fit_hald(0.06);
  EXPECT_THAT(path(model.outputs[0]), ElementsAre("enter x4", "enter x1", "enter x2", "remove x4"));
  EXPECT_NEAR(model.outputs[0].history[3].p, .05168735, 1e-8);
  EXPECT_NEAR(model.outputs[0].history[4].p, .2053954, 1e-7);
  expect_terms(model.outputs[0], "x1+x2");
}

TEST(Hald, NamesTheTermsThatCouldReplaceOneAnother) {
  const Model model = fit_hald(0.06);
  EXPECT_THAT(model.warnings, testing::Contains(testing::HasSubstr("p-values after selection")));
}

}  // namespace
}  // namespace driftwise::calibration
