// Thermometers that show tenths of a degree. Judged against the temperatures that were rounded.

#include "server/diagnosis/rows/coarse_readings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

double shown(double value, double step) { return step * std::round(value / step); }

// A morning in a room, a reading a minute with a noise of 3 mK.
struct Room {
  std::vector<double> time_s, true_degC, shown_degC;

  Room(unsigned seed, std::size_t rows, double step) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double phase = std::uniform_real_distribution<double>(0, 6)(random);
    for (std::size_t i = 0; i < rows; ++i) {
      time_s.push_back(60.0 * static_cast<double>(i));
      true_degC.push_back(20 + 0.4 * std::sin(2 * std::numbers::pi * time_s[i] / 43200 + phase));
      shown_degC.push_back(shown(true_degC[i] + 3e-3 * normal(random), step));
    }
  }
};

TEST(ADisplay, HasTheStepThatItsReadingsAreMultiplesOf) {
  EXPECT_NEAR(display_step(Room(1, 500, 0.1).shown_degC, 0.2), 0.1, 1e-9);
  EXPECT_NEAR(display_step(Room(1, 500, 0.05).shown_degC, 0.2), 0.05, 1e-9);
}

// Readings that change with every row average out, and whole degrees were set by somebody.
TEST(ADisplay, HasNoStepWhereNoiseChangesItOrSomebodySetsIt) {
  EXPECT_EQ(display_step(Room(1, 500, 0.001).shown_degC, 0.2), 0);
  std::vector<double> set(60, 20.0);
  std::fill(set.begin() + 20, set.begin() + 40, 25.0);
  EXPECT_EQ(display_step(set, 0.2), 0);
  EXPECT_EQ(display_step(std::vector<double>(60, 20.0), 0.2), 0);
}

// Twenty rooms. A rounding error is 0.029 K rms.
TEST(TheCourseBetweenSteps, IsNearerThanTheDisplayAndKnowsHowNear) {
  double squares = 0, of_display = 0, known = 0, count = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Room room(seed, 500, 0.1);
    const Course course = between_steps(room.time_s, room.shown_degC, 0.1);
    for (std::size_t i = 0; i < room.time_s.size(); ++i) {
      squares += std::pow(course.values[i] - room.true_degC[i], 2);
      of_display += std::pow(room.shown_degC[i] - room.true_degC[i], 2);
      known += course.unsure.row(static_cast<Eigen::Index>(i)).squaredNorm();
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(of_display / count), 0.029, 0.003);
  EXPECT_LT(std::sqrt(squares / count), 0.015);
  EXPECT_GT(known, squares);
  EXPECT_LT(known, 9 * squares);
}

TEST(TheCourseBetweenSteps, LeavesMissingValuesMissing) {
  Room room(1, 100, 0.1);
  room.shown_degC[7] = NAN;
  const Course course = between_steps(room.time_s, room.shown_degC, 0.1);
  EXPECT_TRUE(std::isnan(course.values[7]));
  EXPECT_EQ(course.unsure.row(7).norm(), 0);
}

EverydayAxis axis_with_a_display(unsigned seed, double nm_per_K) {
  EverydayAxis axis(seed);
  for (std::size_t i = 0; i < EverydayAxis::kRows; ++i) {
    axis.x_mm[i] += (nm_per_K - 60) * 1e-6 * (axis.t01_degC[i] - 20);
    axis.t01_degC[i] = shown(axis.t01_degC[i], 0.1);
  }
  return axis;
}

// A display of 0.1 K hides 0.029 K rms: 4 and 17 nm at these two coefficients, where the noise is
// 5 nm.
TEST(AThermometerOfTenths, RaisesNoFalseCause) {
  for (const double nm_per_K : {150.0, 600.0})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const auto found = axis_with_a_display(seed, nm_per_K).diagnosed();
      EXPECT_THAT(names_found(found), IsEmpty()) << nm_per_K << " nm/K, seed " << seed;
      EXPECT_EQ(found.verdict, Verdict::adequate) << nm_per_K << " nm/K, seed " << seed;
      EXPECT_THAT(found.warnings, Contains(HasSubstr("t01 is read in steps of 0.1 K")));
    }
}

TEST(AThermometerOfTenths, HidesNoWave) {
  EverydayAxis axis = axis_with_a_display(3, 600);
  for (std::size_t i = 0; i < EverydayAxis::kRows; ++i)
    axis.x_mm[i] += 15e-6 * std::sin(2 * std::numbers::pi * axis.q_mm[i] / 1.1);
  EXPECT_THAT(names_found(axis.diagnosed()), ElementsAre(HasSubstr("cyclic_error")));
}

// The part begins at the edge between two tenths, where the display trembles, and leaves it.
TEST(ADisplayThatStandsStill, MayHaveTrembledBefore) {
  EverydayAxis axis(5);
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < EverydayAxis::kRows; ++i) {
    axis.x_mm[i] -= 60e-6 * (axis.t01_degC[i] - 20);
    axis.t01_degC[i] = shown(20.05 + (i < 14 ? 0.004 * normal(random) : 0.03), 0.1);
  }
  EXPECT_THAT(names_found(axis.diagnosed()), IsEmpty());
}

TEST(ADisplayThatStandsStill, IsFrozenOnlyWhereThePartHasMoved) {
  for (const bool moved : {false, true}) {
    EverydayAxis axis(4);
    std::vector<double> other(EverydayAxis::kRows);
    for (std::size_t i = 0; i < EverydayAxis::kRows; ++i) {
      const double part_degC = i < 60 ? 20.2 - 5e-3 * static_cast<double>(i)
                                      : 19.9 + (moved ? 1e-3 : 1e-5) * static_cast<double>(i - 60);
      other[i] = part_degC;
      axis.x_mm[i] += 60e-6 * (part_degC - axis.t01_degC[i]);
      axis.t01_degC[i] = shown(i < 60 ? part_degC : 19.9, 0.1);
    }
    Dataset data = axis.dataset();
    data.columns.push_back({{"t02", "degC"}, other});
    EXPECT_EQ(names_found(diagnosed(data, "q1 ~ x + x^2 + t02")),
              moved ? std::vector<std::string>{"sensor_fault t01"} : std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace driftwise::diagnosis
