#include "server/diagnosis/rows/places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

TEST(Places, LeaveMissingValuesOut) {
  EXPECT_EQ(place_count({1.0, std::nan(""), 2.0}), 2U);
  EXPECT_EQ(place_count({}), 0U);
}

}  // namespace
}  // namespace driftwise::diagnosis
