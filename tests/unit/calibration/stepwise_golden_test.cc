// 360 random problems, among them collinear, tied, tiny-noise and weighted ones, against R's
// add1/drop1 rule (tests/data/stepwise_golden/make_golden.R made golden.txt).

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/criterion_golden.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

struct Expected {
  int state = 0;
  double coefficient = 0, standard_error = 0, t = 0, p = 0;
};

struct Problem {
  int number = 0;
  std::string kind;
  Dataset data;
  int columns = 0;
  FitOptions options;
  std::vector<std::string> path;  // "+3", "-1"
  double rmse = 0;
  int dof = 0;
  std::vector<Expected> terms;  // the constant first
};

std::vector<Problem> read_problems() {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/stepwise_golden/golden.txt");
  std::vector<Problem> problems;
  std::string word;
  while (file >> word) {
    Problem problem;
    std::size_t rows = 0;
    int weighted = 0;
    file >> problem.number >> problem.kind >> rows >> problem.columns >> problem.options.p_enter >>
        problem.options.p_remove >> weighted;
    problem.data.rows = rows;
    problem.data.columns.push_back({{"y", "1"}, {}});
    for (int j = 1; j <= problem.columns; ++j)
      problem.data.columns.push_back({{"x" + std::to_string(j), "1"}, {}});
    if (weighted != 0) {
      problem.data.columns.push_back({{"w", "1"}, {}});
      problem.options.weight_symbol = "w";
    }
    for (std::size_t i = 0; i < rows; ++i) {
      for (auto& column : problem.data.columns) file >> column.values.emplace_back();
    }
    std::getline(file >> std::ws, word);
    std::istringstream path(word.substr(4));
    for (std::string step; path >> step;) problem.path.push_back(step);
    file >> word >> problem.rmse >> problem.dof;
    for (int j = 0; j <= problem.columns; ++j) {
      auto& term = problem.terms.emplace_back();
      file >> term.state >> term.coefficient >> term.standard_error >> term.t >> term.p;
    }
    problem.options.blocks = 0;
    problems.push_back(std::move(problem));
  }
  return problems;
}

std::vector<std::string> path_of(const OutputModel& output) {
  std::vector<std::string> path;
  for (const auto& step : output.history)
    if (step.action != "start")
      path.push_back((step.action == "enter" ? "+" : "-") + effects::notation(step.term).substr(1));
  return path;
}

void expect_close(double value, double golden, double scale, const char* what) {
  // 1e-6 of the value. A coefficient far below its standard error, and its t, agree to 1e-6 of the
  // standard error: noise of 1e-8 stands on data of size 1, whose last bit is 2e-16.
  EXPECT_NEAR(value, golden, 1e-6 * (std::abs(golden) + scale)) << what;
}

TEST(StepwiseGolden, AgreesWithRStepByStepAndNumberByNumber) {
  const auto problems = read_problems();
  ASSERT_EQ(problems.size(), 360u);
  std::map<std::string, int> classes;
  for (const auto& problem : problems) {
    ++classes[problem.kind];
    if (!problem.options.weight_symbol.empty()) ++classes["any weighted"];
  }
  for (const auto* kind : {"collinear", "tied", "tiny"}) EXPECT_EQ(classes[kind], 50) << kind;
  EXPECT_GE(classes["any weighted"], 90);
  for (const auto& problem : problems) {
    SCOPED_TRACE("problem " + std::to_string(problem.number) + " " + problem.kind);
    std::string formula = "y ~ x1";
    for (int j = 2; j <= problem.columns; ++j) formula += " + x" + std::to_string(j);
    const auto model = formats::fit_formula(problem.data, formula, problem.options);
    ASSERT_TRUE(model.has_value()) << model.error().message;
    const auto& output = model->outputs[0];
    ASSERT_EQ(path_of(output), problem.path);
    EXPECT_EQ(output.dof, problem.dof);
    expect_close(output.accuracy.rmse, problem.rmse / std::sqrt(mean_weight(problem.data)), 0,
                 "rmse");
    ASSERT_EQ(output.report.size(), problem.terms.size());
    for (std::size_t j = 0; j < problem.terms.size(); ++j) {
      SCOPED_TRACE("column " + std::to_string(j));
      const auto& golden = problem.terms[j];
      const auto& report = output.report[j];
      EXPECT_EQ(report.in, golden.state == 1);
      if (golden.state < 0) {
        EXPECT_FALSE(report.note.empty()) << "a term that cannot be tried must say why";
        continue;
      }
      expect_close(report.coefficient, golden.coefficient, golden.standard_error, "coefficient");
      expect_close(report.standard_error, golden.standard_error, 0, "standard error");
      expect_close(report.t, golden.t, 1, "t");
      // p of a t that agrees to 1e-6: d(log p) = about -t^2 d(log t)
      if (golden.p > 1e-280) {
        EXPECT_NEAR(report.p / golden.p, 1, 1e-6 * (1 + golden.t * golden.t)) << "p";
      }
    }
  }
}

}  // namespace
}  // namespace driftwise::calibration
