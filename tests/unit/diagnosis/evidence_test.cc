// The numbers of the search, each against something outside the code: dense matrices, numerical
// integration, a known law.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/search/chance.h"
#include "server/diagnosis/search/scan.h"
#include "server/diagnosis/search/search.h"

namespace driftwise::diagnosis {
namespace evidence_test {  // other tests have rows of their own
namespace {

constexpr Eigen::Index kRows = 120;

Timeline timeline() {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> step(5, 40);
  Timeline result;
  result.time_s.resize(kRows);
  double now_s = 0;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    now_s += step(random);
    result.time_s[i] = now_s;
    result.restart.push_back(i == 0 || i == 70 ? 1 : 0);
  }
  return result;
}

// Of the noise, white part 1.
Eigen::MatrixXd covariance_of(const Timeline& when, const NoiseShape& shape) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(kRows, kRows);
  for (Eigen::Index i = 0; i < kRows; ++i)
    for (Eigen::Index j = 0; j < kRows; ++j)
      if ((i < 70) == (j < 70))
        covariance(i, j) +=
            shape.slow_ratio * std::exp(-std::abs(when.time_s[i] - when.time_s[j]) / shape.tau_s);
  return covariance;
}

Eigen::MatrixXd random_columns(Eigen::Index count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, count, [&] { return normal(random); });
}

TEST(WhitenedSpace, LeavesWhatTheMarginalCovarianceLeaves) {
  const Timeline when = timeline();
  const NoiseShape shape{2.0, 90};
  Eigen::MatrixXd columns = random_columns(5, 5);
  columns.col(0).setOnes();
  Eigen::VectorXd precision(5);
  precision << 0, 0, 0, 0.3, 40;
  const WhitenedSpace space(when, shape, independent_base(SoftBase(columns, precision)));
  const Eigen::VectorXd y = random_columns(1, 6);

  // y' Q y of the covariance V + B S B', free columns projected out.
  Eigen::MatrixXd covariance = covariance_of(when, shape);
  for (Eigen::Index k = 3; k < 5; ++k)
    covariance += columns.col(k) * columns.col(k).transpose() / precision[k];
  const Eigen::MatrixXd inverse = covariance.inverse(), x = columns.leftCols(3);
  const Eigen::MatrixXd q =
      inverse - inverse * x * (x.transpose() * inverse * x).inverse() * x.transpose() * inverse;
  EXPECT_NEAR(space.left_over(y).squaredNorm(), y.dot(q * y), 1e-8 * y.dot(q * y));

  // Its determinant, against that of another shape.
  const auto log_determinant = [&](const NoiseShape& of) {
    Eigen::MatrixXd v = covariance_of(when, of);
    for (Eigen::Index k = 3; k < 5; ++k)
      v += columns.col(k) * columns.col(k).transpose() / precision[k];
    const Eigen::MatrixXd information = x.transpose() * v.inverse() * x;
    return 2 * Eigen::MatrixXd(v.llt().matrixL()).diagonal().array().log().sum() +
           std::log(information.determinant());
  };
  const WhitenedSpace white(when, {0, 1}, independent_base(SoftBase(columns, precision)));
  EXPECT_NEAR(space.criterion(1) - white.criterion(1),
              log_determinant(shape) - log_determinant({0, 1}), 1e-6);
}

TEST(Evidence, IsTheIntegralOverTheAmplitude) {
  const Timeline when = timeline();
  const Eigen::MatrixXd column = random_columns(1, 8);
  const Eigen::MatrixXd series = 3 * random_columns(1, 9) + 0.9 * column;
  const Ground ground(when, {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const double width = 1.5, sd = ground.white_sd(0).value;
  const Gain gain = ground.gain(column, Eigen::MatrixXd::Constant(1, 1, width));

  const Eigen::VectorXd y = series.array() - series.mean(), w = column.array() - column.mean();
  double sum = 0;
  const double step = 1e-3;
  for (const double share : {1.0, 0.125, 0.0156, 0.002})  // the prior's widths, with equal odds
    for (double b = -12; b < 12; b += step)
      sum += step / 3 *
             std::exp((y.squaredNorm() - (y - b * w).squaredNorm()) / (2 * sd * sd) -
                      b * b / (2 * share * share * width * width)) /
             (share * width * std::sqrt(2 * std::numbers::pi));
  // The noise's size is estimated in the one and known in the other: second order in gain / rows.
  EXPECT_NEAR(gain.gain, 2 * std::log(sum),
              gain.likelihood * gain.likelihood / static_cast<double>(kRows) + 0.05);
  EXPECT_GT(gain.likelihood, gain.gain) << "the width costs";
}

TEST(Evidence, OfAColumnThatTheBaseAlreadyHasIsNone) {
  const Timeline when = timeline();
  Eigen::MatrixXd base(kRows, 2);
  base << Eigen::VectorXd::Ones(kRows), random_columns(1, 10);
  // Nearly a combination of the base: a free amplitude of a thousand would buy any noise.
  const Eigen::MatrixXd column = base.col(1) + 1e-3 * random_columns(1, 11);
  const Eigen::MatrixXd series = random_columns(1, 12) + 1e3 * (column - base.col(1));
  const Ground ground(when, {{0, 1}}, SoftBase(base), series);
  EXPECT_LT(std::abs(ground.gain(column, Eigen::MatrixXd::Constant(1, 1, 1)).gain), 0.01);
  EXPECT_GT(ground.free_gain(column, {1}).gain, 50) << "what maximum likelihood would say";
}

void expect_the_scan_finds_what_a_search_one_by_one_finds(Eigen::Index outputs) {
  const Timeline when = timeline();
  Bank bank;
  bank.columns = random_columns(12, 13);
  bank.prior = Eigen::MatrixXd::Constant(12, outputs, 0.8);
  for (Eigen::Index k = 0; k < 12; k += 2) {
    bank.cells.push_back({k, 2});
    bank.ln_weight.push_back(std::log(1.0 / 3));
  }
  bank.entries = {{0, 3}, {3, 3}};
  Eigen::MatrixXd series = random_columns(outputs, 14);
  series.col(0) += 0.8 * bank.columns.col(7);  // acts on the first output only
  std::vector<Eigen::MatrixXd> separate;
  for (Eigen::Index o = 0; o < outputs; ++o) separate.emplace_back(series.col(o));
  const Ground ground(when, {{0, 1}, {1, 60}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const auto best = scan(bank, ground, separate, {1, 1}, {{}, {}});
  for (std::size_t e = 0; e < 2; ++e) {
    double sum = 0, top = -1e300;
    for (std::size_t c = 3 * e; c < 3 * e + 3; ++c) {
      const double gain = ground
                              .gain(bank.columns.middleCols(bank.cells[c].first, 2),
                                    bank.prior.middleRows(bank.cells[c].first, 2))
                              .gain;
      sum += std::exp(gain / 2) / 3;
      top = std::max(top, gain);
    }
    EXPECT_NEAR(best[e][0].evidence, 2 * std::log(sum), 1e-3);
    EXPECT_NEAR(best[e][0].gain, top, 1e-3);
  }
  EXPECT_EQ(best[1][0].cell, 0U);
}

TEST(Scan, FindsWhatASearchOneByOneFinds) {
  expect_the_scan_finds_what_a_search_one_by_one_finds(1);
  expect_the_scan_finds_what_a_search_one_by_one_finds(3);
}

TEST(Evidence, WhereACauseDoesNotActItsWidthCostsNoMoreThanTheOdds) {
  const Timeline when = timeline();
  const Eigen::MatrixXd column = random_columns(1, 21);
  Eigen::MatrixXd series = random_columns(2, 22);
  series.col(0) += 0.8 * column;
  const Ground ground(when, {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const Gain gain = ground.gain(column, Eigen::MatrixXd::Constant(1, 2, 1e6));
  EXPECT_GT(gain.of_output[0], 10);
  EXPECT_NEAR(gain.of_output[1], 2 * std::log(0.2), 0.01) << "five possibilities, one of them none";
}

// Twice the log of the density of y where the amplitude of w has the prior N(0, sd^2); white noise
// of 1.
double log_density_2(const Eigen::VectorXd& y, const Eigen::VectorXd& w, double sd) {
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Identity(kRows, kRows) + sd * sd * w * w.transpose();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  return -cholesky.matrixL().solve(y).squaredNorm() -
         2 * Eigen::MatrixXd(cholesky.matrixL()).diagonal().array().log().sum();
}

TEST(LikeliestShare, IsTheModeOfThePosteriorOverThePriorsWidths) {
  const Timeline when = timeline();
  Eigen::VectorXd w = random_columns(1, 23);
  w.array() -= w.mean();
  w.normalize();
  constexpr double kTypical = 2e4;
  const std::vector<double> amplitudes = {2e4, 2500, 400, 40, 0};  // in standard errors
  Eigen::MatrixXd series = random_columns(5, 24);
  for (Eigen::Index o = 0; o < 5; ++o) {
    auto y = series.col(o);
    y.array() -= y.mean();
    y -= w.dot(y) * w;
    y *= std::sqrt(static_cast<double>(kRows - 1)) / y.norm();
    y += amplitudes[static_cast<std::size_t>(o)] * w;
  }
  const Ground ground(when, {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const Gain gain = ground.settled_gain(w, Eigen::MatrixXd::Constant(1, 5, kTypical));
  for (Eigen::Index o = 0; o < 5; ++o) {
    const double none = log_density_2(series.col(o), w, 0);
    double likeliest = 0, most = -INFINITY, acts = 0;
    for (const double share : {1.0, 0.125, 0.0156, 0.002}) {
      const double here = log_density_2(series.col(o), w, share * kTypical);
      acts += std::exp(std::min((here - none) / 2, 700.0)) / 4;
      if (here > most) most = here, likeliest = share;
    }
    if (acts < 1) likeliest = 0;  // equal odds
    EXPECT_EQ(gain.share[static_cast<std::size_t>(o)], likeliest) << o;
  }
  EXPECT_EQ(gain.share, (std::vector<double>{1, 0.125, 0.0156, 0.002, 0})) << "each of them is met";
}

TEST(LikeliestShare, OfACauseOfOneOutputIsNeverNone) {
  EXPECT_EQ(likeliest_share({-9, -6, -2, -1}, true), 0);
  EXPECT_EQ(likeliest_share({-9, -6, -2, -1}, false), 0.002);
  EXPECT_EQ(likeliest_share({-9, -6, -2, 0.5}, true), 0) << "a share so small that it is none";
  EXPECT_EQ(likeliest_share({-9, 5, -2, -1}, true), 0.125);
}

TEST(SharedShape, IsOneForAllOutputsUntilAnotherPaysForItself) {
  Eigen::MatrixXd criterion(2, 3);
  criterion << 0, 0, 3,  //
      20, 20, 0;
  const SharedShape shared = shared_shape(criterion);
  EXPECT_EQ(shared.shape, (std::vector<std::size_t>{0, 0, 0}));
  EXPECT_DOUBLE_EQ(shared.total, 3);
  criterion(0, 2) = 60;
  const SharedShape apart = shared_shape(criterion);
  EXPECT_EQ(apart.shape, (std::vector<std::size_t>{0, 0, 1}));
  EXPECT_DOUBLE_EQ(apart.total, kOwnShape);
}

// Every choice of a shape per output, one by one: all alike for nothing, each that differs at its
// price.
double cheapest(const Eigen::MatrixXd& criterion) {
  double least = INFINITY;
  for (Eigen::Index a = 0; a < criterion.rows(); ++a)
    for (Eigen::Index b = 0; b < criterion.rows(); ++b)
      for (Eigen::Index c = 0; c < criterion.rows(); ++c) {
        const double fit = criterion(a, 0) + criterion(b, 1) + criterion(c, 2);
        const int alike = std::max(
            {1, (a == b) + 1, (b == c) + 1, (a == c) + 1, 3 * static_cast<int>(a == b && b == c)});
        least = std::min(least, fit + (3 - alike) * kOwnShape);
      }
  return least;
}

TEST(SharedShape, IsTheCheapestOfAllChoices) {
  for (unsigned seed = 40; seed < 60; ++seed) {
    const Eigen::MatrixXd criterion = 15 * random_columns(3, seed).topRows(5);
    EXPECT_NEAR(shared_shape(criterion).total, cheapest(criterion), 1e-9) << seed;
  }
}

TEST(Evidence, OfASlowEffectOnOneOutputIsKeptByWhatTheOthersSayOfTheNoise) {
  const Timeline when = timeline();
  const Eigen::VectorXd column = 1.5 * (when.time_s.array() / 300).sin();
  Eigen::MatrixXd series = random_columns(3, 31);
  series.col(0) += column;
  const Eigen::MatrixXd one = series.col(0);
  const std::vector<NoiseShape> grid = noise_grid(when);
  const SoftBase base(Eigen::MatrixXd::Ones(kRows, 1));
  const Eigen::MatrixXd width = Eigen::MatrixXd::Constant(1, 3, 1);
  const double known = Ground(when, {grid.front()}, base, one).gain(column, width.leftCols(1)).gain,
               alone = Ground(when, grid, base, one).gain(column, width.leftCols(1)).gain;
  const Gain beside = Ground(when, grid, base, series).gain(column, width);
  EXPECT_LT(alone, known - 10) << "a slow noise of its own takes most of it";
  EXPECT_GT(beside.gain, alone + 5) << "white in the others, it is white here too";
}

// The same effect under a prior of its size and under one a million times wider: beyond
// the narrowest of its shares.
Look look_for(const Eigen::VectorXd& column, double width, const Eigen::MatrixXd& series) {
  const Timeline when = timeline();
  Bank bank;
  bank.columns = column;
  bank.prior = Eigen::MatrixXd::Constant(1, 1, width);
  bank.cells = {{0, 1}};
  bank.ln_weight = {0};
  bank.entries = {{0, 1}};
  SearchOptions options;
  options.nulls = 999;
  Search search(when, series, bank, options);
  return *search.look(SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), {1});
}

TEST(Search, AWidePriorCostsTheEffectWhatItCostsChance) {
  const Eigen::MatrixXd column = random_columns(1, 33);
  const Eigen::MatrixXd series = random_columns(1, 34) + 0.35 * column;
  const Look narrow = look_for(column, 1, series), wide = look_for(column, 1e6, series);
  const double own = narrow.causes[0].gain - wide.causes[0].gain;
  EXPECT_GT(own, 5) << "the evidence itself";
  EXPECT_LT(std::abs(narrow.causes[0].beyond - wide.causes[0].beyond), own / 2);
  EXPECT_LT(wide.p_adjusted, 0.01);
}

// One effect, two causes that describe it equally well: the one whose prior expects its size is
// named, although the other one is further beyond what chance gives it.
TEST(Search, NamesOfTwoBeyondChanceTheOneWithTheLargerEvidence) {
  const Eigen::MatrixXd column = random_columns(1, 33);
  const Eigen::MatrixXd series = random_columns(1, 34) + 0.6 * column;
  const Timeline when = timeline();
  Bank bank;
  bank.columns.resize(kRows, 2);
  bank.columns << column, column;
  bank.prior = (Eigen::MatrixXd(2, 1) << 1e3, 1).finished();
  bank.cells = {{0, 1}, {1, 1}};
  bank.ln_weight = {0, 0};
  bank.entries = {{0, 1}, {1, 1}};
  Search search(when, series, bank, {});
  const auto look = search.look(SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), {1, 1});
  ASSERT_TRUE(look && look->first);
  EXPECT_LT(look->p_adjusted, 0.003);
  EXPECT_GT(look->causes[0].beyond, look->causes[1].beyond);
  EXPECT_EQ(*look->first, 1U);
}

TEST(EvidenceTail, GivesTheChanceOfTheLargestOfMany) {
  std::mt19937_64 random(15);
  std::uniform_real_distribution<double> even;
  constexpr double kLocation = 4;
  std::vector<double> maxima;
  for (int i = 0; i < 4000; ++i)
    maxima.push_back(kLocation - 2 * std::log(-std::log(even(random))));
  const EvidenceTail tail(maxima);
  for (const double x : {8.0, 14.0, 20.0}) {
    const double p = -std::expm1(-std::exp(-(x - kLocation) / 2));
    EXPECT_NEAR(std::log(tail.p(x)), std::log(p), 0.15 + 0.02 * x);
  }
}

}  // namespace
}  // namespace evidence_test
}  // namespace driftwise::diagnosis
