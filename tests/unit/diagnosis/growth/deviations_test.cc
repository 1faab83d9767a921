// Files of machine tools: deviations beside commanded or nominal positions, and targets that ISO
// 230-2 has read from either side, with an overrun between that no row shows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/formats/formula/formula.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace deviations_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Hidden {
  double play_um = 0, bend_um = 0, ppm_per_k = 0;
  double play_growth_um = 0;  // of the play, from one end to the other
};

// Five runs up and five down over 21 targets; the last target is read, overrun, and read again.
Dataset iso_230_2(const std::string& position, const Hidden& hidden, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> at_mm, deviation_um, t01_degC;
  Dataset data;
  for (std::size_t row = 0; row < 210; ++row) {
    const std::size_t run = row / 21, k = row % 21;
    const bool up = run % 2 == 0;
    const double at = 40.0 * static_cast<double>(up ? k : 20 - k), u = at / 400 - 1;
    const double t01 = 20 + 0.8 * std::sin(static_cast<double>(row) / 37);
    at_mm.push_back(at);
    t01_degC.push_back(t01);
    deviation_um.push_back(
        0.012 * at - (up ? 0.5 : -0.5) * (hidden.play_um + hidden.play_growth_um * at / 800) +
        hidden.bend_um * u * u + 1e-3 * hidden.ppm_per_k * at * (t01 - 20) + 0.35 * normal(random));
    data.time_s.push_back(12.0 * static_cast<double>(row));
  }
  data.rows = data.time_s.size();
  data.columns = {
      {{position, "mm"}, at_mm}, {{"ex", "um"}, deviation_um}, {{"t01", "degC"}, t01_degC}};
  return data;
}

Dataset rows_kept(Dataset data, std::size_t rows) {
  data.rows = rows;
  data.time_s.resize(rows);
  for (auto& column : data.columns) column.values.resize(rows);
  return data;
}

TEST(DeviationsBesidePositions, HaveTheCausesOfAPathAndOfAPoseWhateverThePositionsAreCalled) {
  for (const std::string position : {"x", "q1"}) {
    const std::string baseline = "ex ~ " + position;
    const auto found = [&](const Hidden& hidden, std::uint64_t seed) {
      return names_found(diagnosed(iso_230_2(position, hidden, seed), baseline));
    };
    EXPECT_THAT(found({}, 1), ElementsAre());
    EXPECT_THAT(found({.play_um = 2}, 2), ElementsAre("backlash " + position));
    EXPECT_THAT(found({.bend_um = 1.5}, 3), ElementsAre("geometry_order " + position));
    EXPECT_THAT(found({.ppm_per_k = 8}, 4), ElementsAre("thermal_expansion t01"));
  }
}

TEST(DeviationsBesidePositions, HaveAFormulaInTheNamesOfTheFile) {
  const auto found = diagnosed(iso_230_2("q1", {.bend_um = 1.5}, 3), "ex ~ q1");
  EXPECT_THAT(found.extended_formula, ::testing::StartsWith("ex ~ q1 + q1^2"));
  ASSERT_FALSE(found.findings.empty());
  EXPECT_THAT(found.findings[0].sentence, HasSubstr("q1"));
}

// The file says it from then on, and a fit is as good as the diagnosis promised.
TEST(TargetsReadFromEitherSide, AreAsReachedFromEitherSideWhereAnOverrunIsInNoRow) {
  Dataset data = iso_230_2("x", {.play_um = 2}, 5);
  const auto found = diagnosed(data, "ex ~ x");
  ASSERT_THAT(names_found(found), ElementsAre("backlash x"));
  EXPECT_NEAR(found.findings[0].parameters[0].value, 2000, 250);  // nm
  EXPECT_THAT(found.warnings, Contains(HasSubstr("# overruns: yes")));
  const auto u90 = [&] {
    calibration::FitOptions options;
    options.select = calibration::Select::all;
    return formats::fit_formula(data, "ex ~ x + play(x, 2 um)", options)
        ->outputs.front()
        .accuracy.u90_calibration;
  };
  EXPECT_GT(u90(), 1.645 * 0.4);
  data.metadata.emplace_back("overruns", "yes");
  EXPECT_NEAR(u90(), 1.645 * 0.35, 0.07);
  EXPECT_THAT(diagnosed(data, "ex ~ x").warnings, ::testing::Not(Contains(HasSubstr("overruns"))));
}

// A run up and one down, the play far above the noise. The first target counts as reached on the
// way of the next (ISO 230-2), so that its row is as good as the others.
TEST(TargetsReadFromEitherSide, AreAsReachedOnTheWayFromTheFirstRowOn) {
  Dataset data = rows_kept(iso_230_2("x", {.play_um = 6}, 7), 42);
  const auto found = diagnosed(data, "ex ~ x");
  ASSERT_THAT(names_found(found), ElementsAre("backlash x"));
  EXPECT_NEAR(found.findings[0].parameters[0].value, 6000, 500);  // nm
}

// A ball screw winds up: at its free end more is lost at a reversal than at the bearing.
TEST(APlayThatGrowsAlongAScrew, IsOnePlay) {
  for (const double at_the_bearing_um : {0.0, 1.5}) {
    const auto found =
        diagnosed(iso_230_2("x", {.play_um = at_the_bearing_um, .play_growth_um = 4}, 8), "ex ~ x");
    ASSERT_THAT(names_found(found), ElementsAre("backlash x")) << at_the_bearing_um;
    double growth_nm_per_mm = 0;
    for (const auto& parameter : found.findings[0].parameters)
      if (parameter.name.ends_with("width_nm_per_mm")) growth_nm_per_mm = parameter.value;
    EXPECT_NEAR(growth_nm_per_mm, 4000.0 / 800, 0.6) << at_the_bearing_um;
    EXPECT_NEAR(found.outputs[0].u90_calibration_after, 1645 * 0.35, 80) << at_the_bearing_um;
  }
}

// The motor's reading is the output: it may not stand among the terms that predict it.
TEST(APlayThatGrowsAlongAScrew, HasAFormulaOfThePoseWhereTheMotorIsTheOutput) {
  const Dataset whole = iso_230_2("x", {.play_growth_um = 4}, 8);
  Dataset data;
  std::vector<double> x_mm, q1_mm;
  for (std::size_t row = 0; row < whole.rows; ++row) {
    if (row > 0 && row % 21 == 0) continue;  // no target twice in succession
    x_mm.push_back(whole.columns[0].values[row]);
    q1_mm.push_back(x_mm.back() + 1e-3 * whole.columns[1].values[row]);
    data.time_s.push_back(whole.time_s[row]);
  }
  data.rows = x_mm.size();
  data.columns = {{{"x", "mm"}, x_mm}, {{"q1", "mm"}, q1_mm}};
  const auto found = diagnosed(data, "q1 ~ x");
  ASSERT_THAT(names_found(found), ElementsAre("backlash q1"));
  EXPECT_THAT(found.extended_formula, HasSubstr("x:play(q1"));
  EXPECT_TRUE(formats::fit_formula(data, found.extended_formula, {}));
}

// Motors' readings of targets that a laser calls exact.
Dataset motor_read(const Dataset& deviations, double step_um) {
  Dataset data = deviations;
  auto& reading = data.columns[1];
  reading.channel = {"q1", "mm"};
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double um = 1e3 * data.columns[0].values[row] + reading.values[row];
    reading.values[row] = 1e-3 * (step_um > 0 ? step_um * std::round(um / step_um) : um);
  }
  return data;
}

TEST(TargetsReadFromEitherSide, AreSeenInTheNominalPoseWhereTheMotorIsTheOutput) {
  for (const double step_um : {0.0, 1.0}) {
    const auto found = diagnosed(motor_read(iso_230_2("x", {.play_um = 2}, 9), step_um), "q1 ~ x");
    ASSERT_THAT(names_found(found), ElementsAre("backlash q1")) << step_um;
    EXPECT_NEAR(found.findings[0].parameters[0].value, 2000, 250) << step_um;  // nm
    EXPECT_THAT(found.warnings, Contains(HasSubstr("# overruns: yes"))) << step_um;
  }
}

// An expansion that the simulation lacks is a hundred times the noise and moves from visit to
// visit.
TEST(TargetsReadFromEitherSide, AreSeenBesideAnExpansionThatIsNotSimulated) {
  const auto found = diagnosed(iso_230_2("x", {.play_um = 2, .ppm_per_k = 8}, 10), "ex ~ x");
  EXPECT_THAT(names_found(found),
              ::testing::UnorderedElementsAre("backlash x", "thermal_expansion t01"));
}

// A display of 1 um repeats its values, in more of them than there are targets.
TEST(AMotorReadInCoarseSteps, IsNoPlaceThatWasCommanded) {
  for (std::uint64_t seed = 11; seed < 14; ++seed)
    for (const double step_um : {0.5, 1.0})
      EXPECT_THAT(names_found(diagnosed(motor_read(iso_230_2("x", {}, seed), step_um), "q1 ~ x")),
                  ElementsAre())
          << seed << ' ' << step_um;
}

// "y ~ x": how far a carriage strays from its line is no coordinate, and explains itself.
TEST(Straightness, IsNoCoordinateOfTheMachine) {
  const auto strays = [](const Hidden& hidden) {
    Dataset data = iso_230_2("x", hidden, 15);
    data.columns[1].channel = {"y", "um"};
    return data;
  };
  EXPECT_THAT(names_found(diagnosed(strays({}), "y ~ x")), ElementsAre());
  EXPECT_THAT(names_found(diagnosed(strays({.bend_um = 1.5}), "y ~ x")),
              ElementsAre("geometry_order x"));
  Dataset scattered = strays({});
  std::mt19937_64 random(16);
  std::normal_distribution<double> normal;
  for (std::size_t row = 0; row < scattered.rows; ++row) {
    double& at = scattered.columns[0].values[row];
    at = std::round(std::uniform_real_distribution(0.0, 8e5)(random)) / 1e3;
    scattered.columns[1].values[row] = 0.012 * at + 0.35 * normal(random);
  }
  const auto found = diagnosed(scattered, "y ~ x");
  EXPECT_THAT(names_found(found), ElementsAre());
  EXPECT_EQ(found.verdict, Verdict::adequate);
}

// Read twice where it turns, without an overrun: the second reading is on the same side.
TEST(TargetsReadFromEitherSide, AreOnTheSideThatTheReadingsShow) {
  Dataset data = iso_230_2("x", {}, 6);
  auto& deviation = data.columns[1].values;
  double side = 0;
  for (std::size_t row = 1; row < data.rows; ++row) {
    const auto& at = data.columns[0].values;
    if (at[row] != at[row - 1]) side = at[row] > at[row - 1] ? 1 : -1;
    deviation[row] -= side;
  }
  const auto found = diagnosed(data, "ex ~ x");
  EXPECT_THAT(names_found(found), ElementsAre("backlash x"));
  EXPECT_THAT(found.warnings, ::testing::Not(Contains(HasSubstr("overruns"))));
}

}  // namespace
}  // namespace deviations_test
}  // namespace driftwise::diagnosis
