// Held-out figures where a file has no validation set: each block of time by a fit to the others.
// Judges: the closed form of a straight line, the normal equations, and what a held-out row cannot
// do to its own prediction.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace held_out_test {
namespace {

constexpr std::size_t kRows = 200, kBlock = 20, kGap = 5;  // ten blocks, a quarter on either side

effects::Term linear(const std::string& symbol) { return {{effects::Power{symbol, 1}}}; }

// An axis of 4 mm with 20 nm of noise under a force that acts in the fourth block only.
Dataset axis(std::size_t rows) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> place(-40, 40);
  Dataset data;
  data.rows = rows;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, force{{"force", "N"}, {}};
  for (std::size_t i = 0; i < rows; ++i) {
    x.values.push_back(0.05 * place(random));
    force.values.push_back(i / kBlock == 3 ? normal(random) : 0);
    q.values.push_back(1.001 * x.values.back() + 2e-5 * normal(random));
    data.time_s.push_back(10.0 * static_cast<double>(i));
  }
  data.columns = {q, x, force};
  return data;
}

Problem problem_of(const Dataset& data, std::vector<effects::Term> terms,
                   Judging judging = Judging::in_turn) {
  auto problem = lay_out(data, {"q1 ~ ...", {"q1"}, std::move(terms), true}, 4000, judging);
  EXPECT_TRUE(problem) << problem.error().message;
  return std::move(*problem);
}

bool is_learned_for(std::size_t judged, std::size_t row) {
  const std::size_t begin = judged / kBlock * kBlock;
  return row + kGap < begin || row >= begin + kBlock + kGap;
}

TEST(JudgedResiduals, AreFromTheStraightLineThroughTheOtherBlocks) {
  const Dataset data = axis(kRows);
  const Problem problem = problem_of(data, {linear("x")});
  EXPECT_TRUE(problem.judged_in_turn);
  EXPECT_EQ(problem.learn.size(), kRows) << "the search works on all rows";
  ASSERT_EQ(problem.judge.size(), kRows);
  const auto& output = problem.outputs.front();
  const Eigen::VectorXd judged = judged_residuals(problem, output, problem.base_columns);
  const auto& x = data.find("x")->values;
  for (std::size_t i = 0; i < kRows; i += 7) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t j = 0; j < kRows; ++j) {
      if (!is_learned_for(i, j)) continue;
      const double y = output.measured[static_cast<Eigen::Index>(j)];
      n += 1, sx += x[j], sy += y, sxx += x[j] * x[j], sxy += x[j] * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx), at_0 = (sy - slope * sx) / n;
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(judged[at], output.measured[at] - at_0 - slope * x[i], 1e-6) << i;  // nm of 2e6
  }
}

TEST(JudgedResiduals, OfAColumnWithAPriorAreFromThePosteriorMean) {
  const Problem problem = problem_of(axis(kRows), {linear("x")});
  const auto& output = problem.outputs.front();
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns(problem.base_columns.rows(), 3);
  columns << problem.base_columns,
      Eigen::VectorXd::NullaryExpr(columns.rows(), [&] { return normal(random); });
  const Eigen::Vector3d precision(0, 0, 40);
  const Eigen::VectorXd judged =
      judged_residuals(problem, output, SoftBase(columns, Eigen::VectorXd(precision)));
  for (const std::size_t i : {0U, 55U, 199U}) {
    Eigen::Matrix3d normal_matrix = precision.asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < kRows; ++j) {
      if (!is_learned_for(i, j)) continue;
      const Eigen::Vector3d row = columns.row(static_cast<Eigen::Index>(j)).transpose();
      normal_matrix += row * row.transpose();
      right += row * output.measured[static_cast<Eigen::Index>(j)];
    }
    const Eigen::Vector3d mean = normal_matrix.ldlt().solve(right);
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(judged[at], output.measured[at] - columns.row(at) * mean, 1e-6);
  }
}

TEST(JudgedResiduals, OfARowFollowTheRowAndNothingElseOfItsBlockDoes) {
  Problem problem = problem_of(axis(kRows), {linear("x")});
  const auto of = [&] {
    return judged_residuals(problem, problem.outputs.front(), problem.base_columns);
  };
  const Eigen::VectorXd before = of();
  problem.outputs.front().measured[47] += 1000;  // nm
  const Eigen::VectorXd moved = of() - before;
  for (Eigen::Index i = 40; i < 60; ++i)  // a fit that had seen it would follow
    EXPECT_NEAR(moved[i], i == 47 ? 1000 : 0, 1e-6) << i;
  EXPECT_GT(moved.head(30).cwiseAbs().maxCoeff(), 1) << "other blocks do learn from it";
}

TEST(JudgedRows, LeaveOutABlockWithoutWhichATermIsNotDetermined) {
  const Problem problem = problem_of(axis(kRows), {linear("x"), linear("force")});
  EXPECT_EQ(problem.judge.size(), kRows - kBlock);
  for (const std::size_t row : problem.judge) EXPECT_NE(row / kBlock, 3U);
  EXPECT_EQ(problem.learn.size(), kRows);
}

TEST(JudgedRows, ThatAreLeftOutLaterHaveNoFigure) {
  Problem problem = problem_of(axis(kRows), {linear("x")});
  problem.leave_out({3, 120});
  EXPECT_EQ(problem.judge.size(), kRows - 2);
  const auto judged = judged_residuals(problem, problem.outputs.front(), problem.base_columns);
  EXPECT_EQ(judged.size(), 198);
  EXPECT_LT(judged.cwiseAbs().maxCoeff(), 120) << "nm: six standard deviations";
}

TEST(JudgedRows, AreTheValidationRowsWhereThereAreAny) {
  Dataset data = axis(kRows);
  for (std::size_t i = 0; i < kRows; ++i)
    data.set.push_back(i % 4 == 0 ? PointSet::validation : PointSet::calibration);
  const Problem problem = problem_of(data, {linear("x")});
  EXPECT_TRUE(problem.judged_by_validation);
  EXPECT_FALSE(problem.judged_in_turn);
  EXPECT_EQ(problem.judge.size(), kRows / 4);
  EXPECT_EQ(problem.learn.size(), kRows - kRows / 4);
}

TEST(JudgedRows, KeptApartTakeNoPartInTheSearch) {
  const Problem problem = problem_of(axis(kRows), {linear("x")}, Judging::apart);
  EXPECT_EQ(problem.judge.size(), 2 * kBlock);
  EXPECT_EQ(problem.learn.size(), kRows - 2 * kBlock);
  for (const std::size_t row : problem.judge)
    EXPECT_FALSE(std::ranges::binary_search(problem.learn, row));
}

TEST(JudgedRows, OfALongSeriesAreAllOfThemByFitsToADraw) {
  const Problem problem = problem_of(axis(24'000), {linear("x")});
  EXPECT_EQ(problem.judge.size(), 24'000U);
  for (const auto& fold : problem.folds) {
    EXPECT_EQ(fold.learn.size(), 20'000U);
    EXPECT_TRUE(std::ranges::is_sorted(fold.learn));
  }
}

// Two axes in one room: the first grows with a temperature by 20 nm/K, the second does not.
Dataset two_axes() {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-2, 2);
  Dataset data;
  data.rows = 300;
  DatasetColumn q1{{"q1", "mm"}, {}}, q2{{"q2", "mm"}, {}}, x{{"x", "mm"}, {}}, y{{"y", "mm"}, {}},
      t{{"t01", "degC"}, {}};
  double kelvin = 0;
  for (std::size_t i = 0; i < data.rows; ++i) {
    kelvin = 0.95 * kelvin + 0.3 * normal(random);
    x.values.push_back(place(random));
    y.values.push_back(place(random));
    t.values.push_back(20 + kelvin);
    q1.values.push_back(x.values.back() + 2e-5 * kelvin + 5e-6 * normal(random));
    q2.values.push_back(y.values.back() + 5e-6 * normal(random));
    data.time_s.push_back(30.0 * static_cast<double>(i));
  }
  data.columns = {q1, q2, x, y, t};
  return data;
}

TEST(HeldOutFigures, OfAnOutputThatACauseDoesNotMoveAreAsBefore) {
  const Dataset data = two_axes();
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 + q2 ~ x + y")->expand(data);
  options.nulls = 49;
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->findings.size(), 1U);
  EXPECT_EQ(found->findings.front().subject, "t01");
  EXPECT_EQ(found->rows_held_out, data.rows);
  const auto &moved = found->outputs[0], &other = found->outputs[1];
  EXPECT_LT(*moved.a90_validation_after, 0.5 * *moved.a90_validation_before);
  EXPECT_NEAR(*other.a90_validation_after, *other.a90_validation_before,
              1e-9 * *other.a90_validation_before);
}

// Stacked outputs, each with its own size of error.
Eigen::VectorXd stacked(std::size_t rows, const std::vector<double>& sizes, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd all(static_cast<Eigen::Index>(rows * sizes.size()));
  for (std::size_t i = 0; i < rows * sizes.size(); ++i)
    all[static_cast<Eigen::Index>(i)] = sizes[i / rows] * normal(random);
  return all;
}

TEST(HeldOutFigures, AnOutputThatIsWorseIsHarmAndOneWithinItsIntervalIsNot) {
  const Eigen::VectorXd before = stacked(60, {1, 40}, 1);
  EXPECT_EQ(harm(before, 1.01 * before, 60), 0);
  Eigen::VectorXd after = before;
  after.head(60) *= 1.3;
  EXPECT_NEAR(harm(before, after, 60), 1.3, 1e-9);
  EXPECT_EQ(harm(before, before + stacked(60, {0.1, 4}, 2), 60), 0);
}

TEST(HeldOutFigures, OfTooFewRowsAreComparedOverAllOutputsTogether) {
  const Eigen::VectorXd before = stacked(12, {1, 40, 7}, 3);
  EXPECT_NEAR(harm(before, 1.4 * before, 12), 1.4, 1e-9);
  Eigen::VectorXd one_better = 1.2 * before;
  one_better.head(12) *= 0.2;
  EXPECT_EQ(harm(before, one_better, 12), 0);
  EXPECT_LT(held_out_ratio_together(before, one_better, 12).ratio(), 1);
  EXPECT_EQ(harm(before.head(12), 3 * before.head(12), 12), 0);  // one output: nothing to say
}

}  // namespace
}  // namespace held_out_test
}  // namespace driftwise::diagnosis
