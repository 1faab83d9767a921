#pragma once
// Problems written by tests/data/stepwise_golden/make_criterion_golden.R, and the check of a fit
// against one.

#include <gtest/gtest.h>

#include <cmath>
#include <istream>
#include <sstream>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {

struct CriterionProblem {
  int number = 0;
  std::string criterion, formula;
  Dataset data;
  FitOptions options;
  std::vector<std::string> path;  // "+x3", "-x1:x2"
  double rmse = 0, aic = 0, bic = 0;
  int dof = 0;
};

inline std::vector<CriterionProblem> read_criterion_problems(std::istream& file) {
  std::vector<CriterionProblem> problems;
  std::string word, line;
  while (file >> word) {
    auto& problem = problems.emplace_back();
    int hierarchy = 0, weighted = 0;
    file >> problem.number >> problem.criterion >> hierarchy >> problem.data.rows >> weighted;
    problem.options.criterion = *criterion_named(problem.criterion);
    problem.options.hierarchy = hierarchy != 0;
    problem.options.blocks = 0;
    for (const auto* symbol : {"y", "x1", "x2", "x3", "x4"})
      problem.data.columns.push_back({{symbol, "1"}, {}});
    if (weighted != 0) {
      problem.data.columns.push_back({{"w", "1"}, {}});
      problem.options.weight_symbol = "w";
    }
    std::getline(file >> std::ws, line);
    std::istringstream terms(line.substr(5));
    for (std::string term; terms >> term;)
      problem.formula += (problem.formula.empty() ? "y ~ " : " + ") + term;
    for (std::size_t i = 0; i < problem.data.rows; ++i)
      for (auto& column : problem.data.columns) file >> column.values.emplace_back();
    std::getline(file >> std::ws, line);
    std::istringstream path(line.substr(4));
    for (std::string step; path >> step;) problem.path.push_back(step);
    file >> word >> problem.rmse >> problem.dof >> problem.aic >> problem.bic;
  }
  return problems;
}

inline std::vector<std::string> steps_of(const OutputModel& output) {
  std::vector<std::string> path;
  for (const auto& step : output.history)
    if (step.action != "start")
      path.push_back((step.action == "enter" ? "+" : "-") + effects::notation(step.term));
  return path;
}

// Of the rows that count; 1 without weights. R's sigma is that of a row of weight 1, a model's rms
// that of a row of mean weight: a unit of the weights means nothing.
inline double mean_weight(const Dataset& data) {
  const auto* weights = data.find("w");
  if (weights == nullptr) return 1;
  double sum = 0, rows = 0;
  for (const double weight : weights->values) sum += weight, rows += weight > 0 ? 1 : 0;
  return sum / rows;
}

inline void expect_agreement(const CriterionProblem& problem) {
  SCOPED_TRACE("problem " + std::to_string(problem.number) + " " + problem.criterion + " " +
               problem.formula);
  const auto model = formats::fit_formula(problem.data, problem.formula, problem.options);
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto& output = model->outputs[0];
  ASSERT_EQ(steps_of(output), problem.path);
  EXPECT_EQ(output.dof, problem.dof);
  const double weight = mean_weight(problem.data);
  EXPECT_NEAR(output.accuracy.rmse / problem.rmse * std::sqrt(weight), 1, 1e-9);
  // R's values are sums of a few hundred: 1e-9 of them is 1e-6 of a standard error and better.
  double rows = 0;
  for (std::size_t row = 0; row < problem.data.rows; ++row)
    rows += problem.data.find("w") == nullptr || problem.data.find("w")->values[row] > 0 ? 1 : 0;
  const double by_weight = rows * std::log(weight);  // n ln(RSS / n)
  EXPECT_NEAR(*output.accuracy.aic, problem.aic - by_weight, 1e-8);
  EXPECT_NEAR(*output.accuracy.bic, problem.bic - by_weight, 1e-8);
  if (problem.criterion != "p") {
    EXPECT_NEAR(*output.history.back().value,
                (problem.criterion == "aic" ? problem.aic : problem.bic) - by_weight, 1e-8);
  }
}

}  // namespace driftwise::calibration
