// Both ways from rows to a triangle, X'X and QR: the same model, never less accurate than promised,
// and the same bits on any number of threads.

#include "server/calibration/linear/row_reduction.h"

#include <gmock/gmock.h>

#include <atomic>
#include <random>
#include <thread>

#include "server/calibration/linear/gram.h"
#include "server/calibration/linear/row_qr.h"
#include "server/calibration/linear/tall_kernels.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kReducedFormula = "q1 ~ poly(x, 3) + T";

Executor threads(unsigned count) {
  return [count](std::size_t jobs, const std::function<void(std::size_t)>& job) {
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> crew;
    for (unsigned i = 0; i < count; ++i)
      crew.emplace_back([&] {
        for (std::size_t at = next++; at < jobs; at = next++) job(at);
      });
    for (auto& one : crew) one.join();
  };
}

Model fitted_formula(const Dataset& data, const FitOptions& options, const std::string& formula) {
  const auto model = formats::fit_formula(data, formula, options);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return *model;
}

void expect_same_bits(const Model& a, const Model& b) {
  ASSERT_EQ(a.outputs.size(), b.outputs.size());
  for (std::size_t o = 0; o < a.outputs.size(); ++o) {
    EXPECT_EQ(a.outputs[o].coefficients, b.outputs[o].coefficients);
    EXPECT_EQ(a.outputs[o].covariance, b.outputs[o].covariance);
    EXPECT_EQ(a.outputs[o].accuracy.u90_blocks, b.outputs[o].accuracy.u90_blocks);
    EXPECT_EQ(a.outputs[o].accuracy.rmse, b.outputs[o].accuracy.rmse);
  }
  EXPECT_EQ(a.warnings, b.warnings);
}

TEST(RowReduction, GivesTheSameBitsOnOneTwoAndFourThreads) {
  const Dataset data = make_campaign({.rows = 60000});
  for (const Solver solver : {Solver::qr, Solver::gram}) {
    FitOptions options;
    options.solver = solver;
    const Model here = fitted_formula(data, options, kReducedFormula);
    EXPECT_THAT(here.warnings, Not(Contains(HasSubstr("fast path"))));
    for (const unsigned count : {1u, 2u, 4u}) {
      options.executor = threads(count);
      expect_same_bits(here, fitted_formula(data, options, kReducedFormula));
    }
  }
}

// Noise of 3 nm on 4 mm: y'y would lose 12 of 16 digits of it, were y not taken about a preliminary
// solution.
TEST(RowReduction, GramFindsTheModelOfQrToTenDigits) {
  const Dataset data = make_campaign({.rows = 60000});
  FitOptions options;
  options.solver = Solver::qr;
  const auto exact = fitted_formula(data, options, kReducedFormula).outputs[0];
  options.solver = Solver::gram;
  const auto fast = fitted_formula(data, options, kReducedFormula).outputs[0];
  ASSERT_EQ(fast.terms.size(), exact.terms.size());
  for (Index i = 0; i < exact.coefficients.size(); ++i) {
    const double error = std::sqrt(exact.covariance(i, i));
    EXPECT_LT(std::abs(fast.coefficients[i] - exact.coefficients[i]),
              1e-8 * error + 4e-16 * std::abs(exact.coefficients[i]));  // or its last bit
    EXPECT_GT(digits(std::sqrt(fast.covariance(i, i)), error), 10);
  }
  EXPECT_GT(digits(fast.accuracy.rmse, exact.accuracy.rmse), 10);
  EXPECT_GT(digits(*fast.accuracy.u90_blocks, *exact.accuracy.u90_blocks), 9);
}

TEST(RowReduction, TakesGramByItselfOnManyRowsOnly) {
  FitOptions options;
  for (const auto& [rows, wanted] :
       {std::pair{1500, Solver::qr}, std::pair{300000, Solver::gram}}) {
    const Dataset data = make_campaign({.rows = rows});
    options.candidates = formats::Formula::parse(kReducedFormula)->expand(data).value();
    const auto design = make_design(data, options);
    ASSERT_TRUE(design);
    const RowReduction reduction(*design, {0, design->row_count()}, Solver::automatic, {});
    EXPECT_EQ(reduction.solver(), wanted) << rows << " rows";
  }
}

TEST(RowReduction, LeavesGramWhereColumnsAreAlikeAndSaysSo) {
  Dataset data = make_campaign({.rows = 3000});
  auto& t03 = data.columns[4].values;
  const auto& t01 = data.columns[2].values;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < data.rows; ++i) t03[i] = t01[i] + 1e-4 * normal(random);
  FitOptions options;
  options.solver = Solver::gram;
  const Model model = fitted_formula(data, options, kReducedFormula);
  EXPECT_THAT(model.warnings,
              Contains(testing::StartsWith("the fast path by X'X was left for QR: of t03 only")));
  options.solver = Solver::qr;
  const Model exact = fitted_formula(data, options, kReducedFormula);
  EXPECT_EQ(model.outputs[0].coefficients, exact.outputs[0].coefficients);
}

// Without the block in which t03 moves, nothing tells it from the constant: that fold goes to QR.
TEST(RowReduction, AHeldOutBlockMayTakeTheSafetyAway) {
  Dataset data = make_campaign({.rows = 6000});
  auto& t03 = data.columns[4].values;
  for (std::size_t i = 0; i < data.rows; ++i)
    t03[i] = 21 + (i >= 1200 && i < 1800 ? 1e-3 * static_cast<double>(i % 7) : 0);
  FitOptions options;
  options.solver = Solver::gram;
  const auto fast = fitted_formula(data, options, kReducedFormula);
  EXPECT_THAT(fast.warnings, Not(Contains(HasSubstr("fast path"))));
  options.solver = Solver::qr;
  const auto exact = fitted_formula(data, options, kReducedFormula);
  ASSERT_TRUE(fast.outputs[0].accuracy.u90_blocks);
  EXPECT_GT(digits(*fast.outputs[0].accuracy.u90_blocks, *exact.outputs[0].accuracy.u90_blocks), 8);
}

TEST(GramTriangle, IsTheCholeskyFactorAndStopsAtAnUnsafePivot) {
  std::srand(3);
  MatrixXd x = MatrixXd::Random(200, 5);
  MatrixXd gram = x.transpose() * x;
  const auto safe = gram_triangle(gram, 4);
  EXPECT_LT((safe.joint.leftCols(4).transpose() * safe.joint - gram.topRows(4)).norm(), 1e-12);
  EXPECT_NEAR(safe.joint.col(4).squaredNorm(), gram(4, 4), 1e-12);
  x.col(2) = x.col(0) - x.col(1) + 1e-3 * x.col(2);
  gram = x.transpose() * x;
  const auto unsafe = gram_triangle(gram, 4);
  EXPECT_EQ(unsafe.joint.size(), 0);
  EXPECT_EQ(unsafe.worst, 2);
  EXPECT_LT(unsafe.worst_pivot, 1e-5);
}

// Every shape takes another path through the tiles.
TEST(TallKernels, AgreeWithPlainProductsForEveryWidth) {
  std::srand(11);
  for (Index width = 1; width <= 19; ++width) {
    for (const Index rows : {8, 16, 24, 32, 40, 136}) {
      MatrixXd x = MatrixXd::Random(rows, width), y = MatrixXd::Random(rows, 6);
      const tall::Block a{x.data(), rows, rows, width}, b{y.data(), rows, rows, 6};
      MatrixXd gram = MatrixXd::Zero(width, width), c(width, 6);
      tall::add_gram(a, gram.data());
      const MatrixXd plain = x.transpose() * x;
      for (Index j = 0; j < width; ++j)
        EXPECT_LT((gram.col(j).tail(width - j) - plain.col(j).tail(width - j)).norm(), 1e-12);
      tall::products(a, b, c.data(), width);
      EXPECT_LT((c - x.transpose() * y).norm(), 1e-12);
      const MatrixXd left = y - x * c;
      tall::subtract_product(a, c.data(), width, b);
      EXPECT_LT((y - left).norm() / left.norm(), 1e-14);
    }
  }
}

}  // namespace
}  // namespace driftwise::calibration
