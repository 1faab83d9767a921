#include "server/diagnosis/rows/places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "server/diagnosis/rows/predicted_pose.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

// Different places among the finite values: groups, and each value that stands alone.
std::size_t place_count(const std::vector<double>& values) {
  std::set<double> places;
  for (const double place : by_places(values))
    if (std::isfinite(place)) places.insert(place);
  return places.size();
}

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

// Twelve places of 300 mm, at each a scan of eleven steps of 2 um, four times; the pose is the
// plan's and the motor was measured. 40 nm of a scale of 20 um in 8 nm of noise.
TEST(Places, OfFineScansAtAFewPositionsKeepTheirPhases) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Dataset data;
  std::vector<double> q, x, t01;
  for (int pass = 0; pass < 4; ++pass)
    for (int place = 0; place < 12; ++place)
      for (int step = 0; step < 11; ++step) {
        const double at = 300.0 / 11 * place + 0.002 * step;
        const double t_s = 30.0 * static_cast<double>(data.rows++);
        const double room = 0.3 * std::sin(t_s / 9000);
        x.push_back(at);
        q.push_back(at * (1 - 2e-5) - 5e-9 * at * at - 300e-6 * room -
                    40e-6 * std::sin(2 * std::numbers::pi * at / 0.02 + 0.7) +
                    8e-6 * normal(random));
        t01.push_back(20 + room + 1.5e-3 * normal(random));
        data.time_s.push_back(t_s);
        data.set.push_back(pass == 2 ? PointSet::validation : PointSet::calibration);
      }
  data.columns = {{{"q1", "mm"}, q}, {{"x", "mm"}, x}, {{"t01", "degC"}, t01}};
  const auto found = diagnosed(data, "q1 ~ x + x^2 + t01");
  ASSERT_EQ(names_found(found), std::vector<std::string>{"cyclic_error x"});
  EXPECT_NEAR(found.findings[0].parameters.at(0).value, 20e3, 20);
  EXPECT_LT(found.outputs[0].a90_validation_after.value_or(99), 16) << "nm; noise: 13.2";
}

}  // namespace
}  // namespace driftwise::diagnosis
