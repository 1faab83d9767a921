#pragma once
// The sizes of the published cases and of NUMERICS.md section 2: S1 = 560 x 12, S2 = 756 x 29 with
// three outputs, L1 = 1e5 x 60, L2 = 1e6 x 100.

#include <random>
#include <string>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::bench {

using calibration::FitOptions;

struct Problem {
  Dataset data;
  FitOptions options;
};

inline effects::Term power(const std::string& symbol, int exponent) {
  return {{effects::Power{symbol, exponent}}};
}

// A sum of a third of the columns plus noise of 1e-6.
inline void fill(Problem& problem, int rows, const std::vector<std::string>& symbols, int outputs) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  auto& data = problem.data;
  data.rows = static_cast<std::size_t>(rows);
  for (int o = 1; o <= outputs; ++o) {
    data.columns.push_back({{"q" + std::to_string(o), "mm"}, std::vector<double>(data.rows)});
    problem.options.candidates.outputs.push_back("q" + std::to_string(o));
  }
  int number = 0;
  for (const auto& symbol : symbols) {
    std::vector<double> values(data.rows);
    for (auto& value : values) value = (symbol[0] == 't' ? 21.0 : 0.0) + normal(random);
    for (std::size_t o = 0; o < static_cast<std::size_t>(outputs); ++o)
      for (std::size_t i = 0; i < data.rows; ++i)
        data.columns[o].values[i] += (number % 3 == 0 ? 0.3 : 0.0) * values[i];
    ++number;
    data.columns.push_back({{symbol, "1"}, std::move(values)});
  }
  for (std::size_t o = 0; o < static_cast<std::size_t>(outputs); ++o)
    for (auto& value : data.columns[o].values) value += 1e-6 * normal(random);
}

inline std::vector<std::string> temperatures(int count) {
  std::vector<std::string> names;
  for (int k = 1; k <= count; ++k) names.push_back("t" + std::to_string(k));
  return names;
}

inline Problem case_a() {  // 560 x 12
  Problem problem;
  auto symbols = temperatures(10);
  symbols.insert(symbols.begin(), "x");
  fill(problem, 560, symbols, 1);
  auto& terms = problem.options.candidates.terms;
  terms = {power("x", 1), power("x", 2)};
  for (int k = 1; k <= 10; ++k) terms.push_back(power("t" + std::to_string(k), 1));
  return problem;
}

inline Problem case_b() {  // 756 x 29, three outputs
  Problem problem;
  auto symbols = temperatures(7);
  for (const auto* name : {"x", "y", "z", "force"}) symbols.push_back(name);
  fill(problem, 756, symbols, 3);
  auto& terms = problem.options.candidates.terms;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= 3; ++k) {
        effects::Term term;
        if (i > 0) term.factors.push_back(effects::Power{"x", i});
        if (j > 0) term.factors.push_back(effects::Power{"y", j});
        if (k > 0) term.factors.push_back(effects::Power{"z", k});
        if (!term.is_constant()) terms.push_back(term);
      }
  for (int k = 1; k <= 3; ++k) terms.push_back(power("force", k));
  for (int k = 1; k <= 7; ++k) terms.push_back(power("t" + std::to_string(k), 1));
  return problem;
}

inline Problem many_rows(int rows, int columns) {
  Problem problem;
  fill(problem, rows, temperatures(columns), 1);
  for (const auto& symbol : temperatures(columns))
    problem.options.candidates.terms.push_back(power(symbol, 1));
  return problem;
}

}  // namespace driftwise::bench
