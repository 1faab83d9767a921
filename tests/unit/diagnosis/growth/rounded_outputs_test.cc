// An axis that repeats within 20 nm before a display of 0.1 um, sent to exact positions.

#include "server/diagnosis/rounded_outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct DisplayedAxis {
  EverydayAxis axis;
  std::vector<double> error_mm;

  explicit DisplayedAxis(unsigned seed) : axis(seed), error_mm(EverydayAxis::kRows) {
    std::mt19937_64 random(seed + 1000);
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < EverydayAxis::kRows; ++i) {
      axis.q_mm[i] = 0.25 * std::round(axis.q_mm[i] / 0.25);
      error_mm[i] =
          -20e-6 * axis.q_mm[i] + 150e-6 * (axis.t01_degC[i] - 20) + 20e-6 * normal(random);
    }
  }
  Diagnosis diagnosed(const std::string& formula, double step_mm = 1e-4) {
    for (std::size_t i = 0; i < EverydayAxis::kRows; ++i)
      axis.x_mm[i] = step_mm * std::round((axis.q_mm[i] + error_mm[i]) / step_mm);
    return diagnosis::diagnosed(axis.dataset(), formula);
  }
};

TEST(ADecimalStep, IsTheLargestThatAllValuesAreMultiplesOf) {
  std::vector<double> values;
  for (int i = 0; i < 40; ++i) values.push_back(0.0002 * (i * 7 % 40) + 0.3);
  EXPECT_NEAR(decimal_step(values), 0.0002, 1e-12);
  values[3] += 0.0001;
  EXPECT_NEAR(decimal_step(values), 0.0001, 1e-12);
  values[3] += 0.3e-9;
  EXPECT_LT(decimal_step(values), 1e-9);
}

// Before, probe_hysteresis, noise_change, outliers or `unexplained` in most of them.
TEST(AnOutputReadInCoarseSteps, RaisesNoFalseCause) {
  for (const char* formula : {"x ~ q1 + q1^2 + t01", "q1 ~ x + x^2 + t01"})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const auto found = DisplayedAxis(seed).diagnosed(formula);
      EXPECT_THAT(names_found(found), IsEmpty()) << formula << ", seed " << seed;
      EXPECT_EQ(found.verdict, Verdict::adequate) << formula << ", seed " << seed;
      EXPECT_THAT(found.warnings,
                  Contains(HasSubstr("x_mm is read in steps of 100 nm, and its noise is")));
    }
}

// An axis of 100 mm over 20 places before a display of 1 um, and nothing hidden. On these places
// the steps' saw-tooth is a wave of their own length.
TEST(AnOutputReadInCoarseSteps, IsNoCyclicErrorOfTheStepsLength) {
  for (const unsigned seed : {1U, 2U, 3U})
    for (const double noise_mm : {25e-6, 60e-6}) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      Dataset data;
      data.rows = 400;
      std::vector<double> q, x, t01;
      double part = 20;
      for (std::size_t row = 0; row < data.rows; ++row) {
        const std::size_t k = row % 40;
        part += 0.02 * normal(random);
        q.push_back(100.0 / 19 * static_cast<double>(k < 20 ? k : 39 - k));
        const double at = q[row] * (1 + 30e-6) + 1e-7 * q[row] * q[row] + 400e-6 * (part - 20) +
                          noise_mm * normal(random);
        x.push_back(1e-3 * std::round(1e3 * at));
        t01.push_back(part + 1.5e-3 * normal(random));
        data.time_s.push_back(60.0 * static_cast<double>(row));
        data.set.push_back(row / 20 % 3 == 2 ? PointSet::validation : PointSet::calibration);
      }
      data.columns = {{{"q1", "mm"}, q}, {{"x", "mm"}, x}, {{"t01", "degC"}, t01}};
      const auto found = diagnosis::diagnosed(data, "q1 ~ x + x^2 + t01");
      EXPECT_THAT(names_found(found), IsEmpty()) << seed << ", " << noise_mm;
      EXPECT_EQ(found.verdict, Verdict::adequate) << seed << ", " << noise_mm;
    }
}

TEST(AnOutputReadInCoarseSteps, HidesNoEffectThatIsLarger) {
  for (const char* formula : {"x ~ q1 + q1^2 + t01", "q1 ~ x + x^2 + t01"}) {
    DisplayedAxis jumps(11);
    for (std::size_t i = 200; i < EverydayAxis::kRows; ++i) jumps.error_mm[i] += 300e-6;
    EXPECT_THAT(names_found(jumps.diagnosed(formula)), ElementsAre("step_change x")) << formula;
    DisplayedAxis waves(12);
    for (std::size_t i = 0; i < EverydayAxis::kRows; ++i)
      waves.error_mm[i] += 200e-6 * std::sin(2 * std::numbers::pi * waves.axis.q_mm[i] / 1.1);
    EXPECT_THAT(names_found(waves.diagnosed(formula)), ElementsAre(HasSubstr("cyclic_error")))
        << formula;
  }
}

// Positions that are asked for are multiples of the plan's step, and nothing is rounded.
TEST(NominalPositions, AreNotTakenForADisplay) {
  DisplayedAxis axis(13);
  for (std::size_t i = 0; i < EverydayAxis::kRows; ++i)
    axis.axis.x_mm[i] = axis.axis.q_mm[i] + axis.error_mm[i];
  const auto found = diagnosed(axis.axis.dataset(), "q1 ~ x + x^2 + t01");
  EXPECT_THAT(found.warnings, Not(Contains(HasSubstr("is read in steps"))));
}

// Thirds of a millimetre as a controller is sent them, to a tenth of a micrometre, before a pose
// that scatters by a third of that: no display.
TEST(NominalPositions, AreNoDisplayWhereThePoseScattersByAPartOfTheirStep) {
  DisplayedAxis axis(14);
  for (std::size_t i = 0; i < EverydayAxis::kRows; ++i) {
    axis.axis.q_mm[i] = std::round(axis.axis.q_mm[i] / 0.25 * 3333.3333) / 1e4;
    axis.axis.x_mm[i] = axis.axis.q_mm[i] + 1.5 * axis.error_mm[i];
  }
  const auto found = diagnosed(axis.axis.dataset(), "q1 ~ x + x^2 + t01");
  EXPECT_THAT(found.warnings, Not(Contains(HasSubstr("is read in steps"))));
}

}  // namespace
}  // namespace driftwise::diagnosis
