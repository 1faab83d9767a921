// A thermometer that stands still in a part of the rows while its display repeats values now and
// then anyway.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace frozen_thermometer_test
}  // namespace driftwise::diagnosis
