#include "server/diagnosis/rows/places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/predicted_pose.h"

namespace driftwise::diagnosis {
namespace {

TEST(Places, AreTightGroupsAtTheirMean) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 1e-6);
  std::vector<double> values;
  for (int pass = 0; pass < 20; ++pass)
    for (int k = -4; k <= 4; ++k) values.push_back(k + noise(random));
  EXPECT_EQ(place_count(values), 9U);
  const auto placed = by_places(values);
  EXPECT_EQ(placed[0], placed[9]);
  EXPECT_NEAR(placed[0], -4, 1e-6);
}

TEST(Places, OfAScanOverMicrometresAreAsManyAsItsPoints) {
  std::vector<double> values;
  for (int k = 1; k <= 300; ++k) values.push_back(0.004 * std::fmod(k * 0.6180339887498949, 1.0));
  EXPECT_EQ(place_count(values), 300U);
}

// An askew lattice: each coordinate has as many values as there are places, and a coarse display of
// it fewer; places are told by all of them together.
TEST(Places, AreToldByAllCoordinatesTogether) {
  const std::vector<double> x = {0, 1, 0, 1, 0}, y = {0, 0, 1, 1, 0};
  const std::vector<double> askew = {0, 1, 0.1, 1.1, 0};
  EXPECT_EQ(different_places({&x, &y}), 4U);
  EXPECT_EQ(different_places({&askew}), 4U);
  EXPECT_EQ(different_places({&x}), 2U);
  EXPECT_EQ(different_places({}), 0U);
}

TEST(Places, LeaveMissingValuesOut) {
  EXPECT_EQ(place_count({1.0, std::nan(""), 2.0}), 2U);
  EXPECT_EQ(place_count({}), 0U);
}

}  // namespace
}  // namespace driftwise::diagnosis
