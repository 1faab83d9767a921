// One amplitude in all outputs: an error of one motor, or of the instrument that measures one
// coordinate, is in every output by a slope that is known.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/search/directions.h"
#include "server/diagnosis/search/scan.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace one_amplitude_test {  // other tests have rows of their own
namespace {

constexpr Eigen::Index kRows = 200;

Timeline timeline() {
  Timeline result;
  result.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, 30.0 * (kRows - 1));
  result.restart.assign(kRows, 0);
  result.restart.front() = 1;
  return result;
}

Eigen::MatrixXd normal_columns(Eigen::Index count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, count, [&] { return normal(random); });
}

TEST(OneAmplitude, HasTheEvidenceOfTheIntegralOverItInAllOutputs) {
  std::mt19937_64 random(61);
  const Eigen::MatrixXd column = normal_columns(1, random);
  const Eigen::Vector3d slopes(1, -0.5, 3), noise(2, 1, 9);
  const Eigen::MatrixXd series =
      normal_columns(3, random) * noise.asDiagonal() + 0.4 * column * slopes.transpose();
  const Ground ground(timeline(), {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const Eigen::MatrixXd each = Eigen::MatrixXd::Constant(1, 3, 1.5);
  constexpr double kWidth = 1.5;
  const Along along{slopes, Eigen::MatrixXd::Constant(1, 1, kWidth)};
  const Gain gain = ground.gain(column, each, along);

  const Eigen::MatrixXd y = series.rowwise() - series.colwise().mean();
  const Eigen::VectorXd w = column.array() - column.mean();
  double sum = 0;
  constexpr double kStep = 1e-3;
  for (const double share : {1.0, 0.125, 0.0156, 0.002})  // the prior's widths, with equal odds
    for (double a = -9; a < 9; a += kStep) {
      double two_ln = -std::pow(a / (share * kWidth), 2);
      for (Eigen::Index o = 0; o < 3; ++o)
        two_ln += (y.col(o).squaredNorm() - (y.col(o) - a * slopes[o] * w).squaredNorm()) /
                  std::pow(ground.white_sd(o), 2);
      sum += kStep / 4 / (share * kWidth * std::sqrt(2 * std::numbers::pi)) * std::exp(two_ln / 2);
    }
  const double in_each = std::exp(ground.gain(column, each).gain / 2);
  // The noise's size along the slopes is estimated in the one and known in the other.
  EXPECT_NEAR(gain.gain, 2 * std::log((sum + in_each) / 2),
              gain.likelihood * gain.likelihood / static_cast<double>(kRows) + 0.3);
  EXPECT_EQ(gain.direction, 0);
}

// 36 in 2 ln L, 6 in each of six outputs: each alone is no more than chance.
TEST(OneAmplitude, SeesWhatIsTooWeakInEachOutput) {
  std::mt19937_64 random(62);
  double alone = 0, together = 0;
  constexpr int kSeries = 40;
  for (int i = 0; i < kSeries; ++i) {
    Eigen::MatrixXd column = normal_columns(1, random);
    column /= column.norm();
    const Eigen::MatrixXd series =
        normal_columns(6, random) + std::sqrt(6.0) * column.replicate(1, 6);
    const Ground ground(timeline(), {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
    const Eigen::MatrixXd each = Eigen::MatrixXd::Constant(1, 6, 20);
    const Along along{Eigen::MatrixXd::Ones(6, 1), Eigen::MatrixXd::Constant(1, 1, 20)};
    alone += ground.gain(column, each).gain / kSeries;
    together += ground.gain(column, each, along).gain / kSeries;
  }
  // Of 36 the noise's size, which is told with the effect in, takes 3, and the prior some 9.
  EXPECT_NEAR(together, 24, 2);
  EXPECT_LT(alone, together - 8);
}

TEST(OneAmplitude, CostsAnEffectOfOneOutputNoMoreThanTheOdds) {
  std::mt19937_64 random(63);
  const Eigen::MatrixXd column = normal_columns(1, random);
  Eigen::MatrixXd series = normal_columns(3, random);
  series.col(1) += column;
  const Ground ground(timeline(), {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const Eigen::MatrixXd each = Eigen::MatrixXd::Constant(1, 3, 2);
  const Along along{Eigen::Vector3d(1, 0.1, 1), Eigen::MatrixXd::Constant(1, 1, 2)};
  const Gain without = ground.gain(column, each), with = ground.gain(column, each, along);
  EXPECT_GE(with.gain, without.gain - 2 * std::log(2.0) - 1e-9);
  EXPECT_FALSE(with.direction);
}

TEST(OneAmplitude, IsSaidOfAnUnusualDirectionOnlyWhereThatIsTold) {
  std::mt19937_64 random(64);
  const Eigen::MatrixXd column = normal_columns(1, random);
  const Eigen::MatrixXd noise = normal_columns(3, random);
  Eigen::MatrixXd directions(3, 2);
  directions << 1, 1, 0, 0.1, 0, 0.15;  // nearly the same, and orthogonal
  const Along alike{directions, Eigen::MatrixXd::Constant(1, 2, 2), 1};
  const auto direction_of = [&](const Eigen::Vector3d& truth, const Along& along) {
    const Eigen::MatrixXd series = noise + column * truth.transpose();
    const Ground ground(timeline(), {{0, 1}}, SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
    return ground.gain(column, Eigen::MatrixXd::Constant(1, 3, 2), along).direction;
  };
  EXPECT_NE(direction_of(Eigen::Vector3d(0.3, 0.03, 0.045), alike), 1);
  directions.col(1) << 0, 1, 1;
  const Along apart{directions, Eigen::MatrixXd::Constant(1, 2, 2), 1};
  EXPECT_EQ(direction_of(Eigen::Vector3d(0, 1, 1), apart), 1);
}

TEST(Scan, FindsOneAmplitudeAsTheSearchOneByOneDoes) {
  std::mt19937_64 random(65);
  Eigen::MatrixXd series = normal_columns(3, random) * Eigen::Vector3d(1, 4, 0.3).asDiagonal();
  Bank bank;
  bank.columns = normal_columns(8, random);
  bank.prior = Eigen::MatrixXd::Constant(8, 3, 0.8);
  Eigen::MatrixXd slopes(3, 2);
  slopes << 1, 0, 0.5, 2, -0.2, 0.1;
  for (Eigen::Index k = 0; k < 8; k += 2) {
    bank.cells.push_back({k, 2});
    bank.ln_weight.push_back(std::log(0.5));
  }
  bank.entries = {{0, 2}, {2, 2, {slopes, Eigen::MatrixXd::Constant(4, 2, 0.9)}}};
  series += 0.4 * bank.columns.col(5) * slopes.col(1).transpose();
  std::vector<Eigen::MatrixXd> separate;
  for (Eigen::Index o = 0; o < 3; ++o) separate.emplace_back(series.col(o));
  const Ground ground(timeline(), {{0, 1}, {1, 60}, {3, 400}},
                      SoftBase(Eigen::MatrixXd::Ones(kRows, 1)), series);
  const auto best = scan(bank, ground, separate, {1, 1}, {{}, {}});
  for (std::size_t e = 0; e < 2; ++e) {
    double sum = 0;
    for (std::size_t c = 2 * e; c < 2 * e + 2; ++c) {
      const auto& cell = bank.cells[c];
      sum += std::exp(ground
                          .gain(bank.columns.middleCols(cell.first, 2),
                                bank.prior.middleRows(cell.first, 2),
                                bank.along(bank.entries[e], cell))
                          .gain /
                      2) /
             2;
    }
    EXPECT_NEAR(best[e][0].evidence, 2 * std::log(sum), 2e-3) << e;
  }
}

// Two legs at +-30 degrees to x: plain trigonometry.
TEST(Directions, AreTheSlopesOfTheRobot) {
  const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
  std::mt19937_64 random(66);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 300;
  data.columns = {{{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}, {{"x", "mm"}, {}}, {{"y", "mm"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double x = 10 * uniform(random), y = 10 * uniform(random);
    data.columns[0].values.push_back(c * x + s * y);
    data.columns[1].values.push_back(c * x - s * y);
    data.columns[2].values.push_back(x + 5e-6 * normal(random));
    data.columns[3].values.push_back(y + 5e-6 * normal(random));
    data.time_s.push_back(20.0 * static_cast<double>(i));
  }
  const auto problem =
      lay_out(data, *formats::Formula::parse("q ~ poly(x, y, 2)")->expand(data), 4000);
  ASSERT_TRUE(problem);
  const auto directions = directions_of(*problem, std::nullopt);
  std::vector<std::string> symbols;
  for (const auto& one : directions) symbols.push_back(one.symbol);
  EXPECT_THAT(symbols, testing::ElementsAre("q1", "q2", "x", "y"));
  ASSERT_EQ(directions.size(), 4U);
  EXPECT_TRUE(directions[1].per_unit.isApprox(Eigen::Vector2d(0, 1)));
  EXPECT_TRUE(directions[2].per_unit.isApprox(Eigen::Vector2d(c, c), 1e-5));
  EXPECT_TRUE(directions[3].per_unit.isApprox(Eigen::Vector2d(s, -s), 1e-5));
}

}  // namespace
}  // namespace one_amplitude_test
}  // namespace driftwise::diagnosis
