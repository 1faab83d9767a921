// Several starts: the local optimum escaped, the winner against an exhaustive search, the same on
// any thread.

#include "server/calibration/selection/starts.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <random>
#include <thread>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

// y = x1 - x2 with x1 and x2 nearly alike: alone neither says anything, together they say all. What
// they share and what is x1's own run through every combination, so that chance gives no hint.
Dataset masked_pair() {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> y, x1, x2, x3;
  for (int i = 0; i < 200; ++i) {
    const double common = 10 * (i % 20 - 9.5), own = 0.5 * (i / 20 - 4.5);
    x1.push_back(common + own);
    x2.push_back(common);
    x3.push_back(normal(random));
    y.push_back(own + 0.3 * normal(random));
  }
  return columns_of({{{"y", "1"}, y}, {{"x1", "1"}, x1}, {{"x2", "1"}, x2}, {{"x3", "1"}, x3}});
}

Model fit_with(const Dataset& data, const std::string& formula, int starts,
               const Executor& executor = {}) {
  FitOptions options;
  options.starts = starts;
  options.executor = executor;
  options.blocks = starts > 1 ? 4 : 0;
  const auto model = formats::fit_formula(data, formula, options);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return *model;
}

TEST(Starts, EscapeALocalOptimum) {
  const Dataset data = masked_pair();
  const auto stuck = fit_with(data, "y ~ x1 + x2 + x3", 1).outputs[0];
  EXPECT_EQ(stuck.terms.size(), 1u) << "the pair was no trap";
  EXPECT_TRUE(stuck.starts.empty());
  const auto best = fit_with(data, "y ~ x1 + x2 + x3", 5).outputs[0];
  EXPECT_GE(best.terms.size(), 3u);  // the pair, and x3 where chance favours it
  EXPECT_LT(best.accuracy.rmse, 0.4);
  ASSERT_EQ(best.starts.size(), 5u);
  EXPECT_EQ(best.starts[0].name, "none");
  EXPECT_FALSE(best.starts[0].won);
  EXPECT_EQ(best.starts[1].name, "all");
  EXPECT_TRUE(best.starts[1].won);
  EXPECT_EQ(best.starts[4].name, "random 5");
}

TEST(Starts, OfOneIsTheOrdinaryRule) {
  const auto one = fit_with(make_campaign({}), "q1 ~ poly(x, 4) + T", 1).outputs[0];
  const auto three = fit_with(make_campaign({}), "q1 ~ poly(x, 4) + T", 3).outputs[0];
  EXPECT_LE(*three.accuracy.bic, *one.accuracy.bic);
}

// BIC of the best of all subsets, by R's formula, on the raw columns: an independent, slow way.
double best_subset_bic(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const auto n = static_cast<double>(y.size());
  double best = HUGE_VAL;
  for (unsigned subset = 0; subset < 1U << x.cols(); ++subset) {
    Eigen::MatrixXd design(x.rows(), x.cols() + 1);
    design.col(0).setOnes();
    Eigen::Index k = 1;
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      if ((subset >> j & 1U) != 0) design.col(k++) = x.col(j);
    const Eigen::MatrixXd used = design.leftCols(k);
    const double rss =
        (y - used * (used.transpose() * used).ldlt().solve(used.transpose() * y)).squaredNorm();
    best = std::min(best, n * std::log(rss / n) + std::log(n) * static_cast<double>(k));
  }
  return best;
}

TEST(Starts, FindTheBestOfAllSubsetsMoreOften) {
  std::mt19937 random(77);
  std::normal_distribution<double> normal;
  int alone = 0, several = 0;
  constexpr int kProblems = 60, kColumns = 8;
  for (int problem = 0; problem < kProblems; ++problem) {
    Eigen::MatrixXd x(60, kColumns);
    std::vector<std::pair<Channel, std::vector<double>>> columns;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const double common = 3 * normal(random);
      for (Eigen::Index j = 0; j < kColumns; ++j) x(i, j) = common + normal(random);
    }
    Eigen::VectorXd y(60);
    for (Eigen::Index i = 0; i < 60; ++i)
      y[i] = x(i, 0) - x(i, 1) + 0.5 * x(i, 2) - 0.5 * x(i, 3) + normal(random);
    columns.push_back({{"y", "1"}, {y.begin(), y.end()}});
    std::string formula = "y ~ x1";
    for (Eigen::Index j = 0; j < kColumns; ++j) {
      const std::string name = "x" + std::to_string(j + 1);
      columns.push_back({{name, "1"}, {x.col(j).begin(), x.col(j).end()}});
      if (j > 0) formula += " + " + name;
    }
    const Dataset data = columns_of(std::move(columns));
    const double best = best_subset_bic(x, y);
    FitOptions options;
    options.criterion = Criterion::bic;
    options.blocks = 0;
    const auto found = [&](int starts) {
      options.starts = starts;
      const double bic = *formats::fit_formula(data, formula, options)->outputs[0].accuracy.bic;
      EXPECT_GT(bic, best - 1e-6) << "lower than the lowest";
      return bic < best + 1e-6 ? 1 : 0;
    };
    alone += found(1);
    several += found(20);
  }
  RecordProperty("alone", alone);
  RecordProperty("several", several);
  EXPECT_GT(several, alone);
  EXPECT_GE(several, 54) << "of 60; alone " << alone;
}

TEST(Starts, AreTheSameOnThreadsAndInEveryRun) {
  const Dataset data = make_campaign({.rows = 900});
  const std::string formula = "q1 ~ poly(x, 5) + T + x:T";
  const Executor threaded = [](std::size_t count, const std::function<void(std::size_t)>& job) {
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < count; ++i) threads.emplace_back(job, i);
    for (auto& thread : threads) thread.join();
  };
  const auto here = fit_with(data, formula, 8).outputs[0];
  const auto there = fit_with(data, formula, 8, threaded).outputs[0];
  EXPECT_EQ(here.coefficients, there.coefficients);
  EXPECT_EQ(here.accuracy.u90_blocks, there.accuracy.u90_blocks);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(here.starts[i].value, there.starts[i].value);
    EXPECT_EQ(here.starts[i].began_with, there.starts[i].began_with);
  }
}

TEST(Starts, AreRefusedWhereNothingIsSelected) {
  FitOptions options;
  options.select = Select::all;
  options.starts = 3;
  const auto model = formats::fit_formula(make_campaign({}), "q1 ~ x", options);
  ASSERT_FALSE(model.has_value());
  EXPECT_EQ(model.error().reason, "BAD_OPTIONS");
}

}  // namespace
}  // namespace driftwise::calibration
