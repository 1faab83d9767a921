// The gate against dense matrices: predictive densities as ratios of restricted likelihoods, with
// the parameter weighed and the width of the prior chosen by the learned rows alone.

#include "server/diagnosis/search/entry_gate.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>

namespace driftwise::diagnosis {
namespace entry_gate_test {
namespace {

constexpr Eigen::Index kRows = 120, kFolds = 5, kGapRows = 2;
constexpr std::array<double, 4> kShares = {1, 0.125, 0.0156, 0.002};
constexpr std::array<double, 3> kWeights = {0.5, 0.25, 0.25};  // of the parameter's values
constexpr double kTypical = 5;                                 // of the amplitude

Eigen::MatrixXd random_columns(Eigen::Index count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, count, [&] { return normal(random); });
}

Problem problem_of_an_axis() {
  Dataset data;
  data.rows = static_cast<std::size_t>(kRows);
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}};
  const Eigen::MatrixXd numbers = random_columns(2, 1);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    x.values.push_back(numbers(i, 0));
    q.values.push_back(numbers(i, 0) + 1e-6 * numbers(i, 1));
    data.time_s.push_back(20.0 * static_cast<double>(i));
  }
  data.columns = {q, x};
  auto problem = lay_out(data, {"q1 ~ x", {"q1"}, {{{effects::Power{"x", 1}}}}, true}, 4000);
  EXPECT_TRUE(problem) << problem.error().message;
  return std::move(*problem);
}

Bank bank_of(const Eigen::MatrixXd& columns, Eigen::Index outputs) {
  Bank bank;
  bank.columns = columns;
  bank.prior = Eigen::MatrixXd::Constant(columns.cols(), outputs, kTypical);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    bank.cells.push_back({k, 1});
    bank.ln_weight.push_back(std::log(kWeights[static_cast<std::size_t>(k)]));
  }
  bank.entries = {{0, bank.cells.size()}};
  return bank;
}

// Twice the log of the likelihood of some rows, coefficients of x integrated out flat and that of z
// under N(0, sd^2); white noise of 1.
double restricted_2ln(const std::vector<Eigen::Index>& rows, const Eigen::MatrixXd& all_x,
                      const Eigen::VectorXd& all_z, const Eigen::VectorXd& all_y, double sd) {
  const Eigen::MatrixXd x = all_x(rows, Eigen::all);
  const Eigen::VectorXd z = all_z(rows), y = all_y(rows);
  const Eigen::MatrixXd v =
      Eigen::MatrixXd::Identity(y.size(), y.size()) + sd * sd * z * z.transpose();
  const Eigen::MatrixXd w = v.inverse(), information = x.transpose() * w * x;
  const Eigen::MatrixXd q = w - w * x * information.inverse() * x.transpose() * w;
  return -std::log(v.determinant()) - std::log(information.determinant()) - y.dot(q * y);
}

double brute_force(const Problem& problem, const Eigen::MatrixXd& series, const Bank& bank) {
  const Eigen::MatrixXd& x = problem.base_columns;
  const bool may_not_act = series.cols() > 1;
  double total = 0;
  for (Eigen::Index f = 0; f < kFolds; ++f) {
    const Eigen::Index begin = f * kRows / kFolds, end = (f + 1) * kRows / kFolds;
    std::vector<Eigen::Index> learned, both;
    for (Eigen::Index i = 0; i < kRows; ++i) {
      const bool out = i >= begin && i < end;
      const bool idle = !out && i >= begin - kGapRows && i < end + kGapRows;
      if (!out && !idle) learned.push_back(i);
      if (!idle) both.push_back(i);
    }
    double before = 0, after = 0;  // densities averaged over the parameter
    for (std::size_t c = 0; c < kWeights.size(); ++c) {
      const Eigen::VectorXd z = bank.columns.col(static_cast<Eigen::Index>(c));
      double evidence = 2 * std::log(kWeights[c]), gain = 0;
      for (Eigen::Index o = 0; o < series.cols(); ++o) {
        const Eigen::VectorXd y = series.col(o);
        const auto beyond_none = [&](const std::vector<Eigen::Index>& rows, double sd) {
          return restricted_2ln(rows, x, z, y, sd) - restricted_2ln(rows, x, z, y, 0);
        };
        double sum = may_not_act ? 1 : 0, acts = 0, top = -INFINITY, likeliest = 0;
        for (const double share : kShares) {
          const double two_ln = beyond_none(learned, share * kTypical);
          sum += std::exp(two_ln / 2);
          acts += std::exp(two_ln / 2) / static_cast<double>(kShares.size());
          if (two_ln > top) top = two_ln, likeliest = share;
        }
        if (may_not_act && acts < 1) likeliest = 0;
        evidence += 2 * std::log(sum / static_cast<double>(kShares.size() + (may_not_act ? 1 : 0)));
        gain +=
            beyond_none(both, likeliest * kTypical) - beyond_none(learned, likeliest * kTypical);
      }
      before += std::exp(evidence / 2);
      after += std::exp((evidence + gain) / 2);
    }
    total += 2 * std::log(after / before);
  }
  return total;
}

double score_by_time(const Problem& problem, const Eigen::MatrixXd& series, const Bank& bank) {
  const EntryGate gate(problem, series, bank);
  const auto outputs = static_cast<std::size_t>(series.cols());
  return gate
      .judge(SoftBase(problem.base_columns), std::vector<NoiseShape>(outputs, {0, 1}),
             std::vector<double>(outputs, 1), Cause{}, 0)
      .by_time.value();
}

TEST(EntryGate, ScoresWhatTheLearnedRowsPredict) {
  const Problem problem = problem_of_an_axis();
  for (const double amplitude : {0.0, 0.1, 0.35, 3.0}) {
    const Bank bank = bank_of(random_columns(3, 2), 1);
    const Eigen::MatrixXd series = random_columns(1, 3) + amplitude * bank.columns.col(1);
    const double expected = brute_force(problem, series, bank);
    EXPECT_NEAR(score_by_time(problem, series, bank), expected, 1e-4 * (1 + std::abs(expected)))
        << amplitude;
  }
}

TEST(EntryGate, ScoresNothingForAnOutputThatTheLearnedRowsSayACauseDoesNotMove) {
  const Problem problem = problem_of_an_axis();
  const Bank bank = bank_of(random_columns(3, 2), 3);
  Eigen::MatrixXd series = random_columns(3, 3);
  series.col(0) += 0.35 * bank.columns.col(1);
  const double expected = brute_force(problem, series, bank);
  EXPECT_NEAR(score_by_time(problem, series, bank), expected, 1e-4 * (1 + std::abs(expected)));
  EXPECT_GT(expected, 0);
}

// Twenty times the noise, at an instant inside a block that is left out: the rows beside the block
// do not say where in it, and a wrong place costs 400 a row.
TEST(EntryGate, PassesALargeJumpWhereverItFallsAmongTheBlocks) {
  const Problem problem = problem_of_an_axis();
  for (Eigen::Index at = 40; at < 48; ++at) {
    Bank bank;
    bank.columns = Eigen::MatrixXd::Zero(kRows, kRows - 8);
    for (Eigen::Index c = 0; c < bank.columns.cols(); ++c) {
      bank.columns.col(c).tail(kRows - 4 - c).setOnes();
      bank.cells.push_back({c, 1});
      bank.ln_weight.push_back(-std::log(static_cast<double>(bank.columns.cols())));
    }
    bank.prior = Eigen::MatrixXd::Constant(bank.columns.cols(), 1, 20);
    bank.entries = {{0, bank.cells.size()}};
    Eigen::MatrixXd series = random_columns(1, 3);
    series.bottomRows(kRows - at).array() += 20;
    const EntryGate gate(problem, series, bank);
    Cause jump;
    jump.scale = ParameterScale::instant;
    EXPECT_GT(gate.judge(SoftBase(problem.base_columns), {{0, 1}}, {1}, jump, 0).by_time.value(),
              300)
        << at;
  }
}

// A play's column is some 1e-6 mm large, another cause's some hundred K s.
TEST(EntryGate, DoesNotDependOnTheUnitOfWhatWasFoundBefore) {
  const Problem problem = problem_of_an_axis();
  const Bank bank = bank_of(random_columns(3, 2), 1);
  const Eigen::VectorXd found = random_columns(1, 4);
  const Eigen::MatrixXd series = random_columns(1, 3) + 0.35 * bank.columns.col(1) + 5 * found;
  const auto score = [&](double unit) {
    Eigen::MatrixXd columns(kRows, problem.base_columns.cols() + 1);
    columns << problem.base_columns, unit * found;
    Eigen::VectorXd precision = Eigen::VectorXd::Zero(columns.cols());
    precision[columns.cols() - 1] = unit * unit / 100;
    return EntryGate(problem, series, bank)
        .judge(SoftBase(columns, precision), {{0, 1}}, {1}, Cause{}, 0)
        .by_time.value();
  };
  for (const double unit : {1e-7, 1e-4, 1e4})
    EXPECT_NEAR(score(unit), score(1), 1e-4 * std::abs(score(1))) << unit;
}

}  // namespace
}  // namespace entry_gate_test
}  // namespace driftwise::diagnosis
