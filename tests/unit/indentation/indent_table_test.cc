#include "server/indentation/indent_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/indentation/tip_model.h"

namespace driftwise::indentation {
namespace {

// Table 8.1 of the study (E. Lubrano, EPFL thesis 5098, with F's misprint 1205.02 put right), and
// what follows from it by the formulas, computed by hand.
struct Published {
  const char* id;
  Line line;
  double wanted_um, rx_arcsec, ry_arcsec, measured_um, pixel_nm, marking_px;
  int joined;
  double half_width_um, rotations_um, lever_um, rest_um;
};
constexpr Published kTable[] = {
    {"A", Line::x, 100, -1.6, -0.8, 102.96, 140, 2.5, 0, 0.70, 0.86, 0.39, 2.57},
    {"C", Line::x, 250, -4.3, -2.2, 255.90, 352, 1.5, 0, 1.06, 2.34, 1.07, 4.83},
    {"D", Line::x, 500, -8.6, -4.4, 511.80, 352, 1.5, 1, 1.23, 4.68, 2.13, 9.67},
    {"E", Line::x, 750, -12.0, -6.8, 768.41, 352, 1.5, 2, 1.41, 6.68, 3.30, 15.11},
    {"F", Line::x, 1000, -15.4, -8.9, 1025.02, 352, 1.5, 3, 1.58, 8.62, 4.31, 20.71},
    {"B", Line::y, 100, 1.8, 2.6, 101.39, 140, 2.5, 0, 0.70, 1.53, 0.87, 0.52},
    {"G", Line::y, 250, 4.3, 7.1, 250.62, 352, 1.5, 0, 1.06, 4.02, 2.08, -1.46},
    {"H", Line::y, 500, 8.4, 13.1, 504.76, 352, 1.5, 1, 1.23, 7.54, 4.07, 0.69},
    {"I", Line::y, 750, 12.8, 18.3, 759.26, 352, 1.5, 2, 1.41, 10.82, 6.21, 3.05},
    {"J", Line::y, 1000, 17.2, 25.4, 1013.76, 352, 1.5, 3, 1.58, 14.87, 8.34, 5.42},
};

std::vector<Indent> published() {
  std::vector<Indent> indents;
  for (const auto& p : kTable)
    indents.push_back({p.id, p.line, p.wanted_um, p.rx_arcsec, p.ry_arcsec, p.measured_um,
                       p.pixel_nm, p.marking_px, p.joined, 0});
  return indents;
}

TEST(IndentTable, GivesThePublishedColumns) {
  const auto rows = indent_table(published(), {});
  ASSERT_TRUE(rows);
  constexpr double kRounded = 0.0051;  // printed to 0.01 um
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto& row = (*rows)[i];
    const auto& p = kTable[i];
    EXPECT_NEAR(row.half_width_um, p.half_width_um, kRounded) << p.id;
    EXPECT_NEAR(row.rotations_um, p.rotations_um, 0.0101) << p.id;  // as printed; three are cut
    EXPECT_NEAR(row.lever_um, p.lever_um, kRounded) << p.id;
    EXPECT_NEAR(row.rest_um, p.rest_um, kRounded) << p.id;
  }
}

TEST(IndentTable, GivesTheUncertaintyOfTwoMarkingsAndTheirJoins) {
  const auto rows = *indent_table(published(), {});
  // Two rectangular distributions of +-2.5 pixels of 140 nm.
  EXPECT_NEAR(rows[0].u_um, 0.35 * std::sqrt(2.0 / 3), 1e-9);
  // F: +-1.5 pixels of 352 nm twice, three joins of +-176 nm.
  EXPECT_NEAR(rows[4].u_um, std::sqrt((2 * 0.528 * 0.528 + 3 * 0.176 * 0.176) / 3), 1e-9);
}

TEST(IndentTable, GivesTheForceOfTheStudysDiagonals) {
  EXPECT_NEAR(vickers_force_mN(170, 5), 22, 0.5);
  EXPECT_NEAR(vickers_force_mN(170, 10), 90, 0.5);
}

TEST(IndentTable, RefusesWhatCannotBeMeantAndNamesIt) {
  auto twice = published();
  twice.push_back(twice.front());
  EXPECT_NE(indent_table(twice, {}).error().message.find("'A' is there twice"), std::string::npos)
      << indent_table(twice, {}).error().message;
  auto bad = published();
  bad[3].pixel_nm = 0;
  EXPECT_EQ(indent_table(bad, {}).error().reason, "BAD_VALUE");
  bad = published();
  bad[3].measured_um = NAN;
  EXPECT_EQ(indent_table(bad, {}).error().reason, "BAD_VALUE");
  EXPECT_EQ(indent_table({}, {}).error().reason, "NO_ROWS");
  EXPECT_EQ(indent_table(published(), {.lever_mm = 0}).error().reason, "BAD_VALUE");
}

TEST(TipModel, CannotTellLeverFromScaleInThePublishedTable) {
  const auto report = *tip_report(*indent_table(published(), {}), 0.2);
  ASSERT_EQ(report.lines.size(), 2U);
  // Independent least squares: -1.82 +- 6.31 and 15.09 +- 16.38 by the scatter; the first indent's
  // marking, +-2.5 pixels of 140 nm in every row of a line, moves the factor of x by 1.87.
  EXPECT_NEAR(report.lines[0].factor, -1.82, 0.005);
  EXPECT_NEAR(report.lines[0].u_factor, 6.586, 0.0005);
  EXPECT_NEAR(report.lines[1].factor, 15.09, 0.005);
  EXPECT_NEAR(report.lines[1].u_factor, 16.379, 0.0005);
  EXPECT_NEAR(report.lines[0].u_scale_ppm, 28590, 0.5);  // 27334 by the scatter alone
  EXPECT_NEAR(report.lines[0].correlation, 0.9998, 5e-5);
  EXPECT_NEAR(report.lines[0].lever_share, 0.17, 0.005);
  EXPECT_NEAR(report.lines[1].lever_share, 0.61, 0.005);
  EXPECT_EQ(report.indistinguishable, (std::vector<std::string>{"tool lever", "microscope scale"}));
  EXPECT_FALSE(report.separating.empty());
  EXPECT_TRUE(report.verdict.starts_with("return to step 0"));
  EXPECT_EQ(report.conformity, Conformity::beyond);
}

TEST(TipModel, GivesTheStudysErrorCurvesRefitted) {
  const auto report = *tip_report(*indent_table(published(), {}), 0.2);
  ASSERT_EQ(report.curves.size(), 2U);
  EXPECT_NEAR(report.curves[0].coefficients[1], 0.02469, 5e-6);
  EXPECT_NEAR(report.curves[0].coefficients[0], -0.019, 5e-4);
  EXPECT_NEAR(report.curves[0].rms_um, 0.349, 5e-4);
  EXPECT_NEAR(report.curves[1].coefficients[2], 9.79e-6, 5e-9);
  EXPECT_NEAR(report.curves[1].coefficients[1], 0.00417, 5e-6);
  EXPECT_NEAR(report.curves[1].rms_um, 0.616, 5e-4);
}

TEST(TipModel, TellsLeverFromScaleWhenTheRotationsDoNotGrowWithTheDistance) {
  // A lever 10 % longer than stated and a scale of +2 %, rotations that alternate.
  std::vector<Indent> indents;
  const double ry_arcsec[] = {40, -45, 50, -35, 42};
  for (int i = 0; i < 5; ++i) {
    const double wanted = 200.0 * (i + 1);
    const double lever_um = -100e3 * ry_arcsec[i] / 206264.806;
    indents.push_back({std::to_string(i), Line::x, wanted, 0, ry_arcsec[i],
                       wanted * 1.02 + 1.1 * lever_um, 140, 2.5, 0, 0});
  }
  const auto report = *tip_report(*indent_table(indents, {}), 0.2);
  EXPECT_NEAR(report.lines[0].factor, 1.1, 1e-6);
  EXPECT_NEAR(report.lines[0].scale_ppm, 20000, 1e-3);
  EXPECT_TRUE(report.lines[0].separable);
  EXPECT_TRUE(report.indistinguishable.empty());
}

TEST(TipModel, RefusesAWantedAccuracyThatIsNoLength) {
  const auto rows = indent_table(published(), {});
  ASSERT_TRUE(rows);
  for (const double wanted_um : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_EQ(tip_report(*rows, wanted_um).error().reason, "BAD_VALUE") << wanted_um;
}

// Errors of one sign and size on four indents along x, marked to +-marking_px of 352 nm.
TipReport report_of(const std::vector<double>& errors_um, double marking_px, double wanted_um) {
  std::vector<Indent> indents;
  for (std::size_t i = 0; i < errors_um.size(); ++i) {
    const double at_um = 250.0 * (static_cast<double>(i) + 1);
    indents.push_back({.id = std::string(1, static_cast<char>('A' + i)),
                       .wanted_um = at_um,
                       .rx_arcsec = 0.4,
                       .ry_arcsec = i % 2 == 0 ? -0.3 : 0.5,
                       .measured_um = at_um + errors_um[i],
                       .pixel_nm = 352,
                       .marking_px = marking_px,
                       .pictures_joined = static_cast<int>(i)});
  }
  return *tip_report(*indent_table(indents, {}), wanted_um);
}

// ISO 14253-1: half-widths U of these pictures are 1.06 to 1.58 um with marks of +-1.5 pixels.
TEST(TipModel, SaysWithinOnlyWhereErrorAndUncertaintyAreWithin) {
  EXPECT_EQ(report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 2).conformity, Conformity::within);
  EXPECT_EQ(report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 1.7).conformity, Conformity::within);
  EXPECT_EQ(report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 1.6).conformity, Conformity::undecided);
  EXPECT_EQ(report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 0.2).conformity, Conformity::undecided);
  EXPECT_EQ(report_of({0.1, 0.1, -0.1, 1.7}, 1.5, 0.1).conformity, Conformity::beyond);
  const auto unknown = report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 0.2);
  EXPECT_TRUE(unknown.verdict.starts_with("cannot be told with these pictures")) << unknown.verdict;
  EXPECT_FALSE(unknown.change.empty());
  const auto good = report_of({0.1, 0.1, -0.1, 0.1}, 1.5, 2);
  EXPECT_TRUE(good.verdict.starts_with("accuracy at the tool is within 2000 nm")) << good.verdict;
  EXPECT_TRUE(good.change.empty());
}

// No indent alone is beyond 0.2 um. Independent: the sum on a grid of 1 pm for the first indent's
// marking (numpy) has its least value 11.289; 9.488 is the NIST e-Handbook's, table 1.3.6.7.4.
TEST(TipModel, JudgesTheIndentsOfALineTogether) {
  const auto report = report_of({0.9, 1.1, 1.2, 1.7}, 1.5, 0.2);
  ASSERT_EQ(report.tests.size(), 1U);
  EXPECT_NEAR(report.tests[0].chi2, 11.289, 0.0005);
  EXPECT_NEAR(report.tests[0].limit, 9.488, 0.06);
  EXPECT_EQ(report.conformity, Conformity::beyond);
  EXPECT_TRUE(report.verdict.starts_with("return to step 0: no indent alone")) << report.verdict;
  EXPECT_FALSE(report.indistinguishable.empty());
}

// The first indent marked 0.5 um beside itself shifts the whole line by as much.
TEST(TipModel, TakesAnErrorThatAllIndentsShareAsTheFirstIndentsMarking) {
  EXPECT_EQ(report_of({0.5, 0.5, 0.5, 0.5}, 1.5, 0.2).conformity, Conformity::undecided);
}

}  // namespace
}  // namespace driftwise::indentation
