// Sizes that physics or the cell allows. A robot that its load tilts and a beam off the centre of
// rotation move a length alike; the cell declares the largest offset. A part that grows and air
// that an instrument does not take out scale a length alike; the air's share is at most the whole.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/answer/lever_limits.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kMmPerArcsec = 4.84813681109536e-6;  // per mm of lever

// 300 rows of q1 against x with 5 nm of noise, a tilt ry that wanders and moves x by a lever.
Dataset tilted(double lever_mm) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 300;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, ry{{"ry", "arcsec"}, {}};
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double at_mm = -3 + 6 * std::fmod(0.618 * static_cast<double>(row), 1.0);
    const double tilt = 4 * std::sin(0.37 * static_cast<double>(row)) + 0.3 * normal(random);
    x.values.push_back(at_mm);
    ry.values.push_back(tilt);
    q.values.push_back(at_mm + kMmPerArcsec * lever_mm * tilt + 5e-6 * normal(random));
    data.time_s.push_back(30.0 * static_cast<double>(row));
    data.set.push_back(row % 4 == 3 ? PointSet::validation : PointSet::calibration);
  }
  data.columns = {q, x, ry};
  return data;
}

std::string named(const Dataset& data, const std::optional<LeverLimits>& levers) {
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + x^2")->expand(data);
  options.nulls = 49;
  options.levers = levers;
  const auto found = diagnose(data, options);
  if (!found) return found.error().message;
  std::string names;
  for (const auto& finding : found->findings)
    names += finding.cause + (finding.subject.empty() ? "" : " " + finding.subject) + ";";
  return names;
}

CellDescription with_beam(double a_z_mm, double u_mm) {
  CellDescription cell;
  BeamDescription beam;
  beam.length = {"x", "mm"};
  beam.offset_mm = {15, 0, a_z_mm};
  beam.u_offset_mm = u_mm;
  cell.correction = CorrectionDescription{.cosine = true, .beams = {beam}};
  return cell;
}

TEST(LeverLimits, AreAWrongSignAndTenStandardUncertainties) {
  const auto limits = declared_lever_limits(with_beam(-3, 0.3));
  ASSERT_TRUE(limits);
  EXPECT_DOUBLE_EQ(limits->mm[0][1], 2 * 3 + 3) << "rotation about y, lever along z";
  EXPECT_DOUBLE_EQ(limits->mm[0][2], 3) << "rotation about z, lever along y";
  EXPECT_DOUBLE_EQ(limits->mm[0][0], 0) << "the beam's own direction";
  EXPECT_TRUE(std::isinf(limits->mm[1][0])) << "no beam is declared along y";
}

TEST(LeverLimits, AreNoneWhereTheCellDeclaresNoUncertainty) {
  EXPECT_FALSE(declared_lever_limits(with_beam(-3, 0)));
  EXPECT_FALSE(declared_lever_limits(CellDescription{}));
}

TEST(Plausible, AnOffsetThatTheCellAllowsIsNamed) {
  EXPECT_EQ(named(tilted(2), declared_lever_limits(with_beam(-3, 0.3))), "abbe_offset x;");
}

TEST(Plausible, AnOffsetThatNoMirrorHasIsNotNamed) {
  const Dataset data = tilted(30);
  EXPECT_EQ(named(data, std::nullopt), "abbe_offset x;") << "a file from anywhere says nothing";
  const auto names = named(data, declared_lever_limits(with_beam(-3, 0.3)));
  EXPECT_EQ(names.find("abbe_offset"), std::string::npos) << names;
}

// An axis whose structure grows with t01, which the air around it follows within its readings.
Dataset in_the_same_air(double ppm_per_k, double stroke_mm) {
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 300;
  data.columns = {
      {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}, {{"air", "degC"}, {}}};
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double at_mm = stroke_mm * (std::fmod(0.618 * static_cast<double>(row), 1.0) - 0.5);
    const double warm_k = 0.7 * std::sin(static_cast<double>(row) / 45);
    data.columns[0].values.push_back(at_mm + 1e-6 * ppm_per_k * warm_k * at_mm +
                                     5e-6 * normal(random));
    data.columns[1].values.push_back(at_mm);
    data.columns[2].values.push_back(21 + warm_k + 0.002 * normal(random));
    data.columns[3].values.push_back(21 + warm_k + 0.002 * normal(random));
    data.time_s.push_back(30.0 * static_cast<double>(row));
    data.set.push_back(row % 4 == 3 ? PointSet::validation : PointSet::calibration);
  }
  return data;
}

std::string cause_in(const Dataset& data) {
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + x^2 + T")->expand(data);
  options.nulls = 49;
  const auto found = diagnose(data, options);
  if (!found) return found.error().message;
  std::string names;
  for (const auto& finding : found->findings) names += finding.cause + ";";
  return names;
}

TEST(Plausible, AGrowthOfFivePartsPerMillionIsNotTheAir) {
  EXPECT_EQ(cause_in(in_the_same_air(5, 8)), "thermal_expansion;");
}

TEST(Plausible, AGrowthThatTheAirCanHaveIsTheInstrumentsFirst) {
  EXPECT_EQ(cause_in(in_the_same_air(0.9, 40)), "refractive_index;");
}

}  // namespace
}  // namespace driftwise::diagnosis
