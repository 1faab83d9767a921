#include "server/identification/identifiability.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace driftwise::identification {
namespace {

Eigen::MatrixXd random_columns(int rows, int columns) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd matrix(rows, columns);
  for (auto& value : matrix.reshaped()) value = normal(random);
  return matrix;
}

kinematics::Parameters ranked(std::initializer_list<std::pair<const char*, int>> names) {
  kinematics::Parameters parameters;
  for (const auto& [name, rank] : names) parameters.push_back({name, 0, 1, rank});
  return parameters;
}

TEST(Identifiability, HoldsTheParameterOfTheHighestRankAndNamesTheOthers) {
  Eigen::MatrixXd jacobian = random_columns(40, 4);
  jacobian.col(0) = 2 * jacobian.col(1) - jacobian.col(3);
  const auto result =
      identifiable(jacobian, ranked({{"gauge", 5}, {"length", 0}, {"alone", 0}, {"angle", 1}}));
  EXPECT_EQ(result.free, (std::vector<char>{0, 1, 1, 1}));
  EXPECT_EQ(result.notes[0], "cannot be told apart from length, angle");
}

TEST(Identifiability, NamesWhatHasNoEffectAndWhatTheFileHolds) {
  Eigen::MatrixXd jacobian = random_columns(40, 3);
  jacobian.col(1).setConstant(1e-14);  // rounding
  auto parameters = ranked({{"a", 0}, {"b", 0}, {"c", 0}});
  parameters[2].held = true;
  const auto result = identifiable(jacobian, parameters);
  EXPECT_EQ(result.free, (std::vector<char>{1, 0, 0}));
  EXPECT_EQ(result.notes[1], "has no effect on these rows");
  EXPECT_EQ(result.notes[2], "held by the robot file");
}

TEST(Identifiability, KeepsWhatIsHardButNotImpossibleToTellApart) {
  Eigen::MatrixXd jacobian = random_columns(40, 3);
  jacobian.col(1) = jacobian.col(0) + 1e-5 * jacobian.col(2);
  const auto result = identifiable(jacobian.leftCols(2), ranked({{"a", 0}, {"b", 0}}));
  EXPECT_EQ(result.free, (std::vector<char>{1, 1}));
  EXPECT_GT(result.condition, 1e4);
  EXPECT_LT(result.condition, 1e6);
}

TEST(Identifiability, DoesNotDependOnTheParametersScales) {
  Eigen::MatrixXd jacobian = random_columns(40, 4);
  jacobian.col(0) = 2 * jacobian.col(1) - jacobian.col(3);
  const auto parameters = ranked({{"gauge", 5}, {"length", 0}, {"alone", 0}, {"angle", 1}});
  const auto plain = identifiable(jacobian, parameters);
  jacobian.col(1) *= 1e4;
  jacobian.col(2) *= 1e-4;
  const auto scaled = identifiable(jacobian, parameters);
  EXPECT_EQ(plain.free, scaled.free);
  EXPECT_NEAR(plain.condition, scaled.condition, 1e-9 * plain.condition);
}

TEST(InverseNormal, IsTheInverseOfTheNormalMatrix) {
  Eigen::MatrixXd jacobian = random_columns(40, 4);
  jacobian.col(2) *= 1e6;
  const Eigen::MatrixXd product = inverse_normal(jacobian) * (jacobian.transpose() * jacobian);
  EXPECT_LT((product - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-8);
}

}  // namespace
}  // namespace driftwise::identification
