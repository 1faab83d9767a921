// Noise by correlation length: against whole covariance matrices, by properties.

#include "server/calibration/noise/noise_spectrum.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "server/calibration/noise/serial_noise.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd exponential(Index n, double rows) {
  MatrixXd out(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      out(i, j) = std::exp(-std::abs(static_cast<double>(i - j)) / rows);
  return out;
}

// Noise of this covariance.
VectorXd drawn(std::mt19937& random, const MatrixXd& covariance) {
  std::normal_distribution<double> normal;
  VectorXd white(covariance.rows());
  for (auto& one : white) one = normal(random);
  return covariance.llt().matrixL() * white;
}

// A constant, a slow way and a position that goes back and forth, orthonormal.
MatrixXd campaign_columns(Index n) {
  MatrixXd x(n, 3);
  for (Index i = 0; i < n; ++i)
    x.row(i) << 1, std::exp(-2.0 * static_cast<double>(i) / static_cast<double>(n)),
        static_cast<double>(i % 9) - 4;
  return x.householderQr().householderQ() * MatrixXd::Identity(n, 3);
}

VectorXd residuals_of(const VectorXd& y, const MatrixXd& columns) {
  return y - columns * (columns.transpose() * y);
}

TEST(CosineVariance, IsThatOfTheWholeMatrix) {
  for (const Index n : {7, 40})
    for (const double phi : {0.2, 0.9, 0.995}) {
      MatrixXd cosines(n, n);
      for (Index j = 0; j < n; ++j)
        for (Index i = 0; i < n; ++i)
          cosines(j, i) = std::sqrt((j == 0 ? 1.0 : 2.0) / static_cast<double>(n)) *
                          std::cos(std::numbers::pi * static_cast<double>(j) *
                                   (static_cast<double>(i) + 0.5) / static_cast<double>(n));
      const VectorXd whole =
          (cosines * exponential(n, -1 / std::log(phi)) * cosines.transpose()).diagonal();
      for (Index j = 0; j < n; ++j)
        EXPECT_NEAR(cosine_variance(phi, n, j), whole[j], 1e-10 * whole[0]) << n << " " << phi;
    }
}

TEST(NoiseGram, IsTheProductWithTheWholeMatrix) {
  const MatrixXd z = campaign_columns(40);
  const NoiseSpectrum noise{.white = 2, .slow = {{3, 0.5}, {11, 1.5}}};
  const MatrixXd whole =
      2 * MatrixXd::Identity(40, 40) + 0.5 * exponential(40, 3) + 1.5 * exponential(40, 11);
  EXPECT_LT((noise_gram(z, noise) - z.transpose() * whole * z).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(noise.variance(), 4);
}

// Expected variance of the sum along each column, by whole matrices: the same prior on a grid of
// its own, no transform, no bands.
VectorXd expected_by_whole_matrices(const MatrixXd& columns, const VectorXd& residuals) {
  const Index n = residuals.size(), k = columns.cols();
  const double dof = static_cast<double>(n - k);
  std::vector<MatrixXd> slow;
  constexpr int kSteps = 8;
  for (int i = 0; i < kSteps; ++i)
    slow.push_back(
        exponential(n, 0.7 * std::pow(static_cast<double>(n) / 2 / 0.7, i / (kSteps - 1.0))));
  std::vector<double> logs;
  std::vector<VectorXd> along;
  const auto look = [&](const MatrixXd& covariance, double prior) {
    const Eigen::LLT<MatrixXd> factor(covariance);
    const MatrixXd x = factor.matrixL().solve(columns);
    const VectorXd r = factor.matrixL().solve(residuals);
    const Eigen::LLT<MatrixXd> gram(x.transpose() * x);
    const double squares =
        r.squaredNorm() - VectorXd(gram.matrixL().solve(x.transpose() * r)).squaredNorm();
    logs.push_back(std::log(prior) - dof / 2 * std::log(squares) -
                   factor.matrixLLT().diagonal().array().log().sum() -
                   gram.matrixLLT().diagonal().array().log().sum());
    along.push_back(squares / (dof - 2) * (columns.transpose() * covariance * columns).diagonal());
  };
  const MatrixXd white = MatrixXd::Identity(n, n);
  look(white, 1);
  constexpr int kGrid = 9;
  const auto middle = [](int i) { return (i + 0.5) / kGrid * std::numbers::pi / 2; };
  for (const auto& one : slow)
    for (int a = 0; a < kGrid; ++a)
      look(std::pow(std::cos(middle(a)), 2) * white + std::pow(std::sin(middle(a)), 2) * one,
           1.0 / (kSteps * kGrid));
  // Directions of three deviations: uniform on the sphere's octant, sin(theta) dtheta dphi.
  for (std::size_t i = 0; i < slow.size(); ++i)
    for (std::size_t j = i + 1; j < slow.size(); ++j)
      for (int a = 0; a < kGrid; ++a)
        for (int b = 0; b < kGrid; ++b) {
          const double theta = middle(a), turn = middle(b);
          look(std::pow(std::cos(theta), 2) * white +
                   std::pow(std::sin(theta) * std::cos(turn), 2) * slow[i] +
                   std::pow(std::sin(theta) * std::sin(turn), 2) * slow[j],
               std::sin(theta) * std::numbers::pi / 2 / (28.0 * kGrid * kGrid));
        }
  const double best = *std::ranges::max_element(logs);
  double total = 0;
  VectorXd out = VectorXd::Zero(k);
  for (std::size_t c = 0; c < logs.size(); ++c) {
    total += std::exp(logs[c] - best);
    out += std::exp(logs[c] - best) * along[c];
  }
  return out / total;
}

TEST(NoiseSpectrum, IsTheExpectationByWholeMatrices) {
  constexpr Index kRows = 90;
  const MatrixXd columns = campaign_columns(kRows);
  std::mt19937 random(4);
  for (const auto& [what, covariance] :
       {std::pair("white", MatrixXd(MatrixXd::Identity(kRows, kRows))),
        std::pair("one length", MatrixXd(exponential(kRows, 4))),
        std::pair("two lengths", MatrixXd(0.3 * MatrixXd::Identity(kRows, kRows) +
                                          exponential(kRows, 2) + 1.5 * exponential(kRows, 20)))}) {
    const VectorXd residuals = residuals_of(drawn(random, covariance), columns);
    const VectorXd whole = expected_by_whole_matrices(columns, residuals);
    const VectorXd ours = noise_gram(columns, noise_spectrum(columns, residuals, kRows)).diagonal();
    for (Index i = 0; i < whole.size(); ++i)
      EXPECT_NEAR(std::sqrt(ours[i] / whole[i]), 1, 0.1) << what << ", column " << i;
  }
}

TEST(NoiseSpectrum, FindsTheSlowPartBelowAFastOne) {
  // Instability of two rows and a wander of fifty, 560 rows: the case that one length misses.
  constexpr Index kRows = 560;
  const MatrixXd columns = campaign_columns(kRows);
  const MatrixXd covariance = 1.0 * MatrixXd::Identity(kRows, kRows) + 20 * exponential(kRows, 2) +
                              50 * exponential(kRows, 50);
  const MatrixXd truth = columns.transpose() * covariance * columns;
  std::mt19937 random(5);
  std::vector<double> by_spectrum, by_one_length;
  for (int i = 0; i < 21; ++i) {
    const VectorXd residuals = residuals_of(drawn(random, covariance), columns);
    const SerialNoise one = serial_noise(columns, residuals);
    by_one_length.push_back(one.variance * correlated_gram(columns, one)(1, 1) / truth(1, 1));
    by_spectrum.push_back(noise_gram(columns, noise_spectrum(columns, residuals, kRows))(1, 1) /
                          truth(1, 1));
  }
  const auto median = [](std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + 10);
    return values[10];
  };
  // An expectation: it is more often above the truth than below.
  EXPECT_GT(median(by_spectrum), 0.7);
  EXPECT_LT(median(by_spectrum), 2);
  EXPECT_LT(median(by_one_length), 0.6) << "one length was enough: nothing was tested";
  std::printf("variance of a slow term over the true one: %.2f, by one length %.2f\n",
              median(by_spectrum), median(by_one_length));
}

TEST(NoiseSpectrum, OfStretchesCountsEachAsItsOwnSeries) {
  constexpr Index kRows = 128;
  std::mt19937 random(6);
  VectorXd both(2 * kRows);
  both << drawn(random, exponential(kRows, 6)), drawn(random, exponential(kRows, 6));
  VectorXd turned(2 * kRows);
  turned << both.tail(kRows), both.head(kRows);
  const MatrixXd none(2 * kRows, 0);
  const auto noise = noise_spectrum(none, both, kRows), other = noise_spectrum(none, turned, kRows);
  EXPECT_NEAR(noise.variance(), other.variance(), 1e-9);
  EXPECT_NEAR(noise.slow.back().rows, kRows / 2.0, 1e-9);
}

TEST(NoiseSpectrum, OfAFewRowsIsWhite) {
  const MatrixXd columns = campaign_columns(6);
  const VectorXd residuals = residuals_of(VectorXd::LinSpaced(6, -1, 2), columns);
  const auto noise = noise_spectrum(columns, residuals, 6);
  EXPECT_TRUE(noise.slow.empty());
  EXPECT_DOUBLE_EQ(noise.white, residuals.squaredNorm() / 3);
}

}  // namespace
}  // namespace driftwise::calibration
