#include "server/calibration/linear/undetermined.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/diagnose.h"

namespace driftwise::diagnosis {
namespace {

effects::Term power(const std::string& symbol, int exponent) {
  return {{effects::Power{symbol, exponent}}};
}

TEST(Undetermined, OfThreeForcesTheCubeIsAndAPolynomialOverManyPlacesIsNot) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd of_force(300, 4), of_place(300, 6);
  for (Eigen::Index i = 0; i < 300; ++i) {
    const double levels[] = {0, 1.536, 2.305};
    const double force = levels[i % 3] + 1e-6 * normal(random), x = -2 + 0.5 * double(i % 9);
    for (Eigen::Index k = 0; k < 4; ++k) of_force(i, k) = std::pow(force, k);
    for (Eigen::Index k = 0; k < 6; ++k) of_place(i, k) = std::pow(x, k);
  }
  EXPECT_EQ(calibration::undetermined(of_force, 1), (std::vector<char>{0, 0, 0, 1}));
  EXPECT_EQ(calibration::undetermined(of_place, 1), (std::vector<char>(6, 0)));
}

// Calibrated under three forces, validated under two others, as in the published case B.
TEST(Undetermined, TermsOfABaselineDoNotRunAwayWhereItIsJudged) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  Dataset data;
  for (const char* name : {"q1_mm", "x_mm", "force_N"})
    data.columns.push_back({*parse_channel(name), {}});
  const double forces[] = {0, 1.536, 2.305, 0.768, 3.842};
  for (int block = 0; block < 5; ++block)
    for (int i = 0; i < 60; ++i) {
      const double x = 0.25 * (i % 10), force = forces[block] + 1e-7 * normal(random);
      data.time_s.push_back(10.0 * (60 * block + i));
      data.set.push_back(block < 3 ? PointSet::calibration : PointSet::validation);
      data.columns[0].values.push_back(x + 1e-6 * (100 * force + 5 * normal(random)));
      data.columns[1].values.push_back(x);
      data.columns[2].values.push_back(force);
      ++data.rows;
    }
  DiagnoseOptions options;
  options.baseline = {"q1 ~ x + F + F^2 + F^3",
                      {"q1"},
                      {power("x", 1), power("force", 1), power("force", 2), power("force", 3)},
                      true};
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->outputs.front().u90_validation_before);
  EXPECT_LT(*found->outputs.front().u90_validation_before, 30);  // nm; noise: 8.2
  ASSERT_FALSE(found->warnings.empty());
  EXPECT_NE(found->warnings.front().find("force^3"), std::string::npos) << found->warnings.front();
}

}  // namespace
}  // namespace driftwise::diagnosis
