// Selection of a linear model's columns: a number is named where it stands in every way that the
// rows may be seen.

#include "server/diagnosis/robot/parameter_selection.h"

#include <gtest/gtest.h>

#include <random>

namespace driftwise::diagnosis {
namespace {

using Role = ParameterSelection::Role;

constexpr Eigen::Index kRows = 80;

Eigen::MatrixXd drawn(Eigen::Index columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(kRows, columns, [&] { return normal(random); });
}

class Selection : public testing::Test {
 protected:
  // Columns 0 and 1 act, by 2 and 3 noises of a row; 3 is always in.
  Eigen::MatrixXd columns_ = drawn(4, 5);
  Eigen::VectorXd noise_ = drawn(1, 6);
  Eigen::VectorXd y_ = noise_ + 2 * columns_.col(0) + 3 * columns_.col(1) + 3 * columns_.col(3);
  std::vector<Role> roles_{Role::offered, Role::offered, Role::offered, Role::always_in};
};

TEST_F(Selection, TakesWhatActsTheStrongestFirst) {
  ParameterSelection selection({{columns_, y_}}, roles_);
  selection.select(0.003);
  EXPECT_EQ(selection.chosen(), (std::vector<std::size_t>{1, 0}));
  EXPECT_NEAR(selection.coefficients()[1], 3, 0.5);
  EXPECT_EQ(selection.coefficients_of_none()[1], 0);
  EXPECT_NEAR(selection.coefficients_of_none()[3], 3, 1.5);
}

TEST_F(Selection, NamesNoNumberThatOneWayToSeeTheRowsDoesNotShow) {
  const Eigen::VectorXd other = y_ - 2 * columns_.col(0);  // seen so, the first acts no more
  ParameterSelection selection({{columns_, y_}, {columns_, other}}, roles_);
  selection.select(0.003);
  EXPECT_EQ(selection.chosen(), std::vector<std::size_t>{1});
}

TEST_F(Selection, WhatIsForbiddenStaysOut) {
  ParameterSelection selection({{columns_, y_}}, roles_);
  selection.select(0.003);
  selection.forbid(1);
  selection.select(0.003);
  EXPECT_EQ(selection.chosen(), std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace driftwise::diagnosis
