// Wrong values that everyday data have: a thermometer that reads kelvins too much for a few rows, a
// reading lost to zero, wrong rows that follow one another. Nothing else may get a name for them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/core/data/reading.h"
#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::size_t> wrong_rows(const Diagnosis& found) {
  for (const auto& finding : found.findings)
    if (finding.cause == "outliers") return finding.rows;
  return {};
}

TEST(AThermometer, ThatIsOffForTwoRowsIsToldAndNothingIsNamedForIt) {
  EverydayAxis axis(1);
  for (const std::size_t row : {50U, 51U}) axis.t01_degC[row] += 5;
  const auto found = axis.diagnosed();
  EXPECT_THAT(names_found(found), IsEmpty());
  EXPECT_THAT(found.warnings, Contains(HasSubstr("t01 gives 2 values far off their neighbours")));
}

TEST(AThermometer, ThatIsOffForFiveRowsHasAFault) {
  EverydayAxis axis(2);
  for (std::size_t row = 250; row < 255; ++row) axis.t01_degC[row] += 1;
  EXPECT_THAT(names_found(axis.diagnosed()), ElementsAre("sensor_fault t01"));
}

// A part that follows t01, which the baseline does not read, with a lag of 5000 s: 900 nm/K, and 8
// nm of noise. wrong: what is done to t01.
template <typename Wrong>
Diagnosis lagging(const Wrong& wrong) {
  constexpr double kStep_s = 60, kTau_s = 5000, kPerKelvin_mm = 900e-6, kSpread_mm = 8e-6;
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 400;
  std::vector<double> q, x, t01, t02;
  double room = 20, second = 20, body = 20;
  for (std::size_t row = 0; row < data.rows; ++row) {
    const std::size_t k = row % 40;
    room += 0.03 * normal(random), second += 0.03 * normal(random);
    body += (room - body) * (1 - std::exp(-kStep_s / kTau_s));
    q.push_back(5.0 * static_cast<double>(k < 20 ? k : 39 - k));
    x.push_back(q[row] + 1e-7 * q[row] * q[row] + 400e-6 * (second - 20) +
                kPerKelvin_mm * (body - 20) + kSpread_mm * normal(random));
    t01.push_back(room + 1.5e-3 * normal(random));
    t02.push_back(second + 1.5e-3 * normal(random));
    data.time_s.push_back(kStep_s * static_cast<double>(row));
    data.set.push_back(row / 20 % 3 == 2 ? PointSet::validation : PointSet::calibration);
  }
  wrong(t01);
  data.columns = {
      {{"q1", "mm"}, q}, {{"x", "mm"}, x}, {{"t01", "degC"}, t01}, {{"t02", "degC"}, t02}};
  return diagnosed(data, "q1 ~ x + x^2 + t02");
}

// Rows 105 and 150: one that judges, one that learns.
TEST(AThermometerOfACause, LosesNothingByOneWrongReading) {
  const auto empty = lagging([](auto& t01) { t01[105] = t01[150] = kMissing; });
  ASSERT_THAT(names_found(empty), ElementsAre("thermal_lag t01"));
  const auto wrong = lagging([](auto& t01) { t01[105] += 5, t01[150] += 5; });
  EXPECT_THAT(wrong.warnings, Contains(HasSubstr("t01 gives 2 values far off")));
  EXPECT_THAT(names_found(wrong), ElementsAre("thermal_lag t01"));
  EXPECT_NEAR(wrong.outputs[0].a90_validation_after.value_or(0),
              empty.outputs[0].a90_validation_after.value_or(-1), 0.5);
}

TEST(AThermometerOfACause, TeachesNothingWhileItIsFrozen) {
  const auto found = lagging([](auto& t01) { std::fill_n(t01.begin() + 250, 60, t01[250]); });
  EXPECT_THAT(names_found(found), ElementsAre("sensor_fault t01", "thermal_lag t01"));
  EXPECT_THAT(found.warnings, Contains("59 of 400 rows have no value of t01 and were left out"));
  EXPECT_LT(found.outputs[0].a90_validation_after.value_or(99), 17);  // 1.645 x 8 nm
}

// A door of a few seconds, seen once by rows that lie a minute apart, and twice as well by the
// thermometer that is nearer.
TEST(Thermometers, ThatLeaveTogetherForARowAreLeftAsTheyAre) {
  EverydayAxis axis(4);
  Dataset data = axis.dataset();
  data.columns.push_back({{"t02", "degC"}, axis.t01_degC});
  data.columns[2].values[250] -= 0.1;
  data.columns[3].values[250] -= 0.05;
  const auto found = diagnosed(data, "q1 ~ x + x^2 + T");
  EXPECT_THAT(found.warnings, Not(Contains(HasSubstr("far off"))));
}

// No room does that, though both do.
TEST(Thermometers, ThatAreLostToZeroTogetherAreLeftOut) {
  EverydayAxis axis(5);
  Dataset data = axis.dataset();
  data.columns.push_back({{"t02", "degC"}, axis.t01_degC});
  data.columns[2].values[250] = data.columns[3].values[250] = 0;
  const auto found = diagnosed(data, "q1 ~ x + x^2 + T");
  EXPECT_THAT(found.warnings, Contains(HasSubstr("t01 gives 1 value far off its neighbours")));
  EXPECT_THAT(found.warnings, Contains(HasSubstr("t02 gives 1 value far off its neighbours")));
}

TEST(AReadingLostToZero, IsAWrongRowAndBendsNothingElse) {
  for (const bool of_motor : {false, true}) {
    EverydayAxis axis(3);
    (of_motor ? axis.q_mm : axis.x_mm)[250] = 0;
    const auto found = axis.diagnosed();
    EXPECT_THAT(names_found(found), ElementsAre("outliers")) << of_motor;
    EXPECT_THAT(wrong_rows(found), ElementsAre(250));
    EXPECT_LT(found.outputs[0].u90_calibration_after, 10);  // 1.645 x 5 nm, and the row is out
  }
}

// 80 nm, 16 standard deviations: four alone and two in succession.
TEST(WrongRows, AreFoundOneByOneAndInSuccession) {
  EverydayAxis axis(4);
  for (const std::size_t row : {40U, 133U, 250U, 251U, 390U, 477U}) axis.x_mm[row] += 80e-6;
  const auto found = axis.diagnosed();
  EXPECT_THAT(names_found(found), ElementsAre("outliers"));
  EXPECT_THAT(wrong_rows(found), ElementsAre(40, 133, 250, 251, 390, 477));
}

// Up and down over eleven places of a rail, a reading every eight seconds. um: what the reading is
// off, of its row.
template <typename Off>
Dataset rail(std::size_t rows, const Off& um) {
  Dataset data;
  std::vector<double> x, ex;
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t k = row % 22;
    x.push_back(50.0 * static_cast<double>(k < 11 ? k : 21 - k));
    ex.push_back(0.01 * x.back() + um(row));
    data.time_s.push_back(8.0 * static_cast<double>(row));
  }
  data.rows = rows;
  data.columns = {{{"x", "mm"}, x}, {{"ex", "um"}, ex}};
  return data;
}

// The beam was touched once: the rows before and after are off their neighbours' mean as well, by
// half, and are no tail of the noise.
TEST(OneWrongRow, IsFoundInAShortFile) {
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const std::size_t wrong = 10 + 9 * seed;
    const auto found = diagnosed(rail(110,
                                      [&](std::size_t row) {
                                        return 0.5 * normal(random) +
                                               (row == wrong ? (seed % 2 == 0 ? 10 : -10) : 0);
                                      }),
                                 "ex ~ x");
    if (found.findings.size() == 1 && wrong_rows(found) == std::vector{wrong}) ++right;
  }
  EXPECT_GE(right, 9);
}

// 8 standard deviations, three rows of 198, either sign; the next of the noise is at 2.8.
TEST(ThreeWrongRows, AreFoundThoughAStudentLawHasSuchTails) {
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto found =
        diagnosed(rail(198,
                       [&](std::size_t row) {
                         const bool wrong = row == 40 || row == 97 || row == 151;
                         return 0.5 * normal(random) + (wrong ? row % 2 == 0 ? 4 : -4 : 0);
                       }),
                  "ex ~ x");
    if (found.findings.size() == 1 && wrong_rows(found) == std::vector<std::size_t>{40, 97, 151})
      ++right;
  }
  EXPECT_GE(right, 8);
}

// Noise that holds for three rows: the wrong row's neighbours agree with one another, and what is
// left of them, whitened, has the error in the next row too.
TEST(ThreeWrongRows, AreFoundInNoiseThatIsCorrelatedFromRowToRow) {
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double slow = 0;
    const auto found = diagnosed(rail(198,
                                      [&](std::size_t row) {
                                        slow = 0.7 * slow + 0.5 * std::sqrt(0.51) * normal(random);
                                        const bool wrong = row == 40 || row == 97 || row == 151;
                                        return slow + (wrong ? row % 2 == 0 ? 4 : -4 : 0);
                                      }),
                                 "ex ~ x");
    if (found.findings.size() == 1 && wrong_rows(found) == std::vector<std::size_t>{40, 97, 151})
      ++right;
  }
  EXPECT_GE(right, 8);
}

// The first row after a new zero, and then lunch: the robot is another one when the rest comes.
TEST(OneWrongRow, IsNotARowBetweenAZeroAndAPause) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Dataset data = rail(120, [&](std::size_t row) {
      return 0.5 * normal(random) + (row >= 60 ? -6 : 0) + (row == 60 ? 9 : 0);
    });
    for (std::size_t row = 0; row < data.rows; ++row) {
      data.datum.push_back(row < 60 ? 1 : 2);
      data.time_s[row] += row > 60 ? 3000 : 0;
    }
    EXPECT_THAT(wrong_rows(diagnosed(data, "ex ~ x")), IsEmpty()) << seed;
  }
}

// Noise of Student's law with three degrees of freedom: an error of ten robust standard deviations
// in every third file.
TEST(OneWrongRow, IsNotTheLargestOfNoiseWithHeavyTails) {
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 random(1000 + seed);
    std::student_t_distribution<double> heavy(3);
    const auto found =
        diagnosed(rail(220, [&](std::size_t) { return 0.3 * heavy(random); }), "ex ~ x");
    named += wrong_rows(found).empty() ? 0 : 1;
  }
  EXPECT_LE(named, 1);
}

}  // namespace
}  // namespace driftwise::diagnosis
