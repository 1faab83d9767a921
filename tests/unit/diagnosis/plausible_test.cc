// A robot that its load tilts, and a beam beside the centre of rotation, move a length alike. How
// far beside it can be, the cell declares.

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

}  // namespace
}  // namespace driftwise::diagnosis
