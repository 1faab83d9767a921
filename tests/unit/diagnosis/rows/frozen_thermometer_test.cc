// A thermometer that stands still in a part of the rows while its display repeats values now and
// then anyway.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace frozen_thermometer_test {
namespace {

using ::testing::Contains;

// Hundredths of a degree, up to eight equal ones in succession: a seventh of the rows is only nine
// times as long.
Diagnosis of_hundredths(bool freezes, double room_k) {
  EverydayAxis axis(61);
  constexpr std::size_t kFirst = 260, kLast = 330;
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    const double room = room_k * std::sin(axis.time_s[row] / 4200);
    axis.t01_degC[row] = 20 + room;
    axis.x_mm[row] =
        axis.q_mm[row] + 3e-5 * axis.q_mm[row] * axis.q_mm[row] + 60e-6 * room +
        (axis.x_mm[row] - axis.q_mm[row] - 3e-5 * axis.q_mm[row] * axis.q_mm[row]) * 0.1;
  }
  const double stood = axis.t01_degC[kFirst];
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    if (freezes && row > kFirst && row <= kLast) axis.t01_degC[row] = stood;
    axis.t01_degC[row] = std::round(100 * axis.t01_degC[row]) / 100;
  }
  return axis.diagnosed();
}

TEST(AThermometerThatStandsStill, IsFrozenWhereThePartHasMovedMeanwhile) {
  EXPECT_THAT(names_found(of_hundredths(true, 0.5)), Contains("sensor_fault t01"));
  EXPECT_THAT(names_found(of_hundredths(false, 0.5)), ::testing::Not(Contains("sensor_fault t01")));
}

// Two parts that follow the room, the second one's display stuck between two rows; or the second
// at rest until the last of them.
Diagnosis of_two_parts(double display_k, std::size_t first, std::size_t last, double noise_k,
                       bool second_part_moves) {
  EverydayAxis axis(62);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Dataset data = axis.dataset();
  std::vector<double> t02;
  const auto shown = [&](double value) { return display_k * std::round(value / display_k); };
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    const double room = 0.6 * std::sin(axis.time_s[row] / 3000);
    const double base = second_part_moves ? 0.8 * room : row < last ? 0 : 0.8;
    t02.push_back(shown(21 + base + noise_k * normal(random)));
    axis.t01_degC[row] = shown(20 + room + noise_k * normal(random));
    axis.x_mm[row] = axis.q_mm[row] + 3e-5 * axis.q_mm[row] * axis.q_mm[row] + 60e-6 * room +
                     200e-6 * base + 5e-6 * normal(random);
  }
  if (second_part_moves)
    for (std::size_t row = first; row < last; ++row) t02[row] = t02[first];
  data = axis.dataset();
  data.columns.push_back({{"t02", "degC"}, t02});
  return diagnosed(data, "q1 ~ x + x^2 + T");
}

// Thousandths that tremble from row to row do not repeat fifty times.
TEST(AThermometerThatStandsStill, IsFrozenWhereItsNoiseMovesItElsewhere) {
  EXPECT_THAT(names_found(of_two_parts(0.001, 200, 255, 0.002, true)),
              ::testing::ElementsAre("sensor_fault t02"));
}

// A display of tenths, standing for two hours while the room goes by a kelvin.
TEST(AThermometerThatStandsStill, IsFrozenWhereTheOthersForetellMoreThanItsSteps) {
  EXPECT_THAT(names_found(of_two_parts(0.1, 200, 320, 0.01, true)), Contains("sensor_fault t02"));
}

// A machine that rests, and then is switched on: the same display stands still until it warms.
TEST(AThermometerThatStandsStill, IsNoneWhereThePartRests) {
  EXPECT_THAT(names_found(of_two_parts(0.1, 0, 300, 0.01, false)),
              ::testing::Not(Contains("sensor_fault t02")));
}

// Two parts with courses of their own; the second one's thermometer stands still from a row on.
Diagnosis of_a_part_of_its_own(std::size_t from, unsigned seed) {
  EverydayAxis axis(seed);
  std::mt19937_64 random(seed + 7);
  std::normal_distribution<double> normal;
  std::vector<double> t02;
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    const double room = 0.6 * std::sin(axis.time_s[row] / 3000),
                 part = 0.5 * std::sin(axis.time_s[row] / 1700 + 1);
    axis.t01_degC[row] = 20 + room + 0.001 * normal(random);
    t02.push_back(row < from ? 21 + part + 0.001 * normal(random) : t02.back());
    axis.x_mm[row] = axis.q_mm[row] + 3e-5 * axis.q_mm[row] * axis.q_mm[row] + 60e-6 * room +
                     90e-6 * part + 5e-6 * normal(random);
  }
  Dataset data = axis.dataset();
  data.columns.push_back({{"t02", "degC"}, t02});
  return diagnosed(data, "q1 ~ x + x^2 + t01 + t02");
}

// Two others foretell that it fell by 0.12 K meanwhile, and miss it by 0.05 K where it moves.
TEST(AThermometerThatStandsStill, IsNoneWhereTheOthersDoNotForetellIt) {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/data/plateau/null_5700041_study.csv");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto data = formats::read_dataset_csv(text, "null_5700041_study.csv");
  ASSERT_TRUE(data);
  const auto found = diagnosed(*data, "q1 ~ x + x^2 + T");
  EXPECT_THAT(found.findings, ::testing::IsEmpty());
  EXPECT_EQ(found.verdict, Verdict::adequate);
}

// Half of the rows tell what the robot does with the part's temperature: the others wait for it.
TEST(AThermometerThatStandsStill, CostsItsRowsAndNothingStandsInForIt) {
  for (const unsigned seed : {71, 72}) {
    const auto found = of_a_part_of_its_own(EverydayAxis::kRows / 2, seed);
    EXPECT_THAT(names_found(found), ::testing::ElementsAre("sensor_fault t02"));
    EXPECT_THAT(
        found.warnings,
        Contains(::testing::HasSubstr("a value of an output or of a term of the baseline")));
  }
}

// Nine rows do not tell five coefficients.
TEST(AThermometerThatStandsStill, LeavesTheBaselineWhereItsRowsAreTooFew) {
  const auto found = of_a_part_of_its_own(9, 71);
  EXPECT_THAT(names_found(found), Contains("sensor_fault t02"));
  EXPECT_THAT(found.warnings, ::testing::Not(Contains(::testing::HasSubstr(
                                  "a value of an output or of a term of the baseline"))));
}

}  // namespace
}  // namespace frozen_thermometer_test
}  // namespace driftwise::diagnosis
