// Findings about an instrument that no instrument can have.

#include "server/application/diagnoses/instrument_agreement.h"

#include <gmock/gmock.h>

#include <Eigen/QR>
#include <cmath>

#include "server/core/units.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {
namespace {

using testing::HasSubstr;

// 60 rows in which x runs over 2.5 mm and the tilt over 20 arcsec, independently.
Dataset tilting_workspace() {
  Dataset data;
  data.rows = 60;
  DatasetColumn x{{"x", "mm"}, {}}, ry{{"ry", "arcsec"}, {}};
  for (int i = 0; i < 60; ++i) {
    data.time_s.push_back(60.0 * i);
    x.values.push_back(2.5 * (i % 10) / 9.0);
    ry.values.push_back(20.0 * ((i * 7) % 60) / 59.0 - 10);
  }
  data.columns = {x, ry};
  return data;
}

// What three motors of a delta show when the instrument of x errs by these mm per unit of the term.
InstrumentClaim seen_by(const std::vector<double>& error_mm_by_output) {
  InstrumentClaim claim;
  claim.outputs = {{"q1", "mm"}, {"q2", "mm"}, {"q3", "mm"}};
  claim.axes = {"x"};
  claim.slopes = Eigen::Vector3d(1.0, -0.5, -0.5);
  claim.seen_mm.resize(3, 1);
  for (int o = 0; o < 3; ++o)
    claim.seen_mm(o, 0) = -claim.slopes(o, 0) * error_mm_by_output[static_cast<std::size_t>(o)];
  claim.error_mm = -claim.slopes.colPivHouseholderQr().solve(claim.seen_mm);
  return claim;
}

diagnosis::Finding finding_with(const std::string& cause, const std::string& term,
                                const InstrumentClaim& claim, double gain_2lnl = 400) {
  diagnosis::Finding finding;
  finding.cause = cause;
  finding.subject = "x";
  finding.applies_to = effects::AppliesTo::correction;
  finding.terms = {*formats::parse_term(term)};
  for (std::size_t o = 0; o < claim.outputs.size(); ++o) {
    diagnosis::FindingOutput output;
    output.output = claim.outputs[o].symbol;
    output.unit = "nm";
    output.gain_2lnl = gain_2lnl;
    output.shown = true;
    output.coefficients = {claim.seen_mm(static_cast<Eigen::Index>(o), 0)};
    finding.outputs.push_back(output);
  }
  return finding;
}

// mm of length per mm and arcsec: a beam turned by this angle.
double beam_angle(double arcsec) { return arcsec * kRadPerArcsec * kRadPerArcsec; }

TEST(InstrumentAgreement, OneBeamWithOneAngleIsAccepted) {
  const auto claim = seen_by({beam_angle(40), beam_angle(41), beam_angle(39)});
  const auto ok =
      check_instrument(1, finding_with("cosine_error", "x:ry", claim), claim, tilting_workspace());
  EXPECT_TRUE(ok) << ok.error().message;
}

TEST(InstrumentAgreement, ThreeAnglesForOneBeamAreRefused) {
  const auto claim = seen_by({beam_angle(40), beam_angle(-310), beam_angle(120)});
  const auto refused =
      check_instrument(2, finding_with("cosine_error", "x:ry", claim), claim, tilting_workspace());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "OUTPUTS_DISAGREE");
  EXPECT_THAT(refused.error().message, HasSubstr("finding 2 (cosine_error x)"));
  EXPECT_THAT(refused.error().message,
              HasSubstr("q1 says 40 arcsec, q2 says -310 arcsec, q3 says 120 arcsec"));
}

// The same three angles, where each output knows its own to no better than that.
TEST(InstrumentAgreement, WeakEvidenceIsNoDisagreement) {
  const auto claim = seen_by({beam_angle(40), beam_angle(-310), beam_angle(120)});
  EXPECT_TRUE(check_instrument(2, finding_with("cosine_error", "x:ry", claim, 1.5), claim,
                               tilting_workspace()));
}

TEST(InstrumentAgreement, AnOutputThatShouldShowItAndDoesNotIsADisagreement) {
  auto claim = seen_by({beam_angle(40), 0, 0});
  claim.slopes = Eigen::Vector3d(1.0, 1.0, 1.0);
  claim.error_mm = -claim.slopes.colPivHouseholderQr().solve(claim.seen_mm);
  const auto refused =
      check_instrument(1, finding_with("cosine_error", "x:ry", claim), claim, tilting_workspace());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "OUTPUTS_DISAGREE");
}

struct Impossible {
  const char* name;
  const char *cause, *term;
  double possible_mm, impossible_mm;  // per unit of the term
  const char* said;
};
class InstrumentLimits : public testing::TestWithParam<Impossible> {};
TEST_P(InstrumentLimits, TellTheImpossible) {
  const auto& row = GetParam();
  const auto good = seen_by({row.possible_mm, row.possible_mm, row.possible_mm});
  const auto ok =
      check_instrument(1, finding_with(row.cause, row.term, good), good, tilting_workspace());
  EXPECT_TRUE(ok) << ok.error().message;
  const auto bad = seen_by({row.impossible_mm, row.impossible_mm, row.impossible_mm});
  const auto refused =
      check_instrument(1, finding_with(row.cause, row.term, bad), bad, tilting_workspace());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "IMPOSSIBLE_PARAMETER");
  EXPECT_THAT(refused.error().message, HasSubstr(row.said));
}
INSTANTIATE_TEST_SUITE_P(
    Table, InstrumentLimits,
    testing::Values(
        // 279 527 arcsec are 78 degrees: the beam is not there any more.
        Impossible{"Angle", "cosine_error", "x:ry", beam_angle(300), beam_angle(279'527),
                   "angle of the beam of 280000 arcsec: at most 3600 arcsec"},
        Impossible{"Scale", "instrument_drift", "x:drift()", 0.9e-6, 126e-6,
                   "drift of the scale of 126 ppm/h: at most 10 ppm/h"},
        Impossible{"ScaleDown", "instrument_drift", "x:drift()", -0.9e-6, -70e-6,
                   "drift of the scale of -70 ppm/h"},
        Impossible{"Zero", "instrument_drift", "drift()", 300e-6, 0.5, "drift of the zero"},
        Impossible{"Lever", "abbe_offset", "ry", 30 * kRadPerArcsec, 4000 * kRadPerArcsec,
                   "lever arm of 4000 mm"},
        Impossible{"Wave", "cyclic_error", "sin(x, 316.4 nm)", 5e-6, 120e-6,
                   "amplitude of 120 nm"}),
    [](const auto& row) { return std::string(row.param.name); });

// Sine and cosine of 70 nm each are a wave of 99 nm: a quarter of its period is 79.1.
TEST(InstrumentLimits, AreOfTheWholeWave) {
  auto claim = seen_by({50e-6, 50e-6, 50e-6});
  auto finding = finding_with("cyclic_error", "sin(x, 316.4 nm)", claim);
  finding.terms.push_back(*formats::parse_term("cos(x, 316.4 nm)"));
  for (auto& output : finding.outputs) output.coefficients.push_back(output.coefficients.front());
  const auto with_both = [&](double each_mm) {
    auto both = claim;
    both.seen_mm = Eigen::MatrixXd::Constant(3, 2, 0);
    for (int o = 0; o < 3; ++o) both.seen_mm.row(o).setConstant(-claim.slopes(o, 0) * each_mm);
    both.error_mm = -claim.slopes.colPivHouseholderQr().solve(both.seen_mm);
    return both;
  };
  const auto possible = with_both(50e-6), impossible = with_both(70e-6);
  EXPECT_TRUE(check_instrument(1, finding, possible, tilting_workspace()));
  const auto refused = check_instrument(1, finding, impossible, tilting_workspace());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "IMPOSSIBLE_PARAMETER");
  EXPECT_THAT(refused.error().message, HasSubstr("amplitude of 99 nm: at most 79.1 nm"));
}

}  // namespace
}  // namespace driftwise::application
