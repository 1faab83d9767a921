#include "server/diagnosis/report/sentence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace driftwise::diagnosis {
namespace {

Finding with(const std::string& parameter, double value) {
  Finding finding{.cause = "abbe_offset", .subject = "x"};
  finding.parameters.push_back({parameter, value, {}, {}});
  finding.outputs.push_back({.output = "q1", .unit = "nm"});
  finding.outputs.push_back({.output = "x", .unit = "nm"});
  return finding;
}

bool says(const Finding& finding, const std::string& words) {
  return sentence(finding).find(", " + words) != std::string::npos;
}

TEST(Sentence, GivesEveryNumberItsUnitWhateverStandsBehindIt) {
  EXPECT_TRUE(says(with("tau_s", 1830), "tau 1830 s."));
  EXPECT_TRUE(says(with("offset_mm", 2.5), "offset 2.5 mm."));
  EXPECT_TRUE(says(with("offset_mm_rx_q1", -51.7), "offset rx -51.7 mm (q1)."));
  EXPECT_TRUE(says(with("size_nm_x", 158), "size 158 nm (x)."));
  EXPECT_TRUE(says(with("nm_per_k_q1", 940), "940 nm/K (q1)."));
  EXPECT_TRUE(says(with("nm_per_k_per_h", -209), "-209 nm/(K/h)."));
  EXPECT_TRUE(says(with("nm_per_n_per_mm", 8), "8 nm/(N mm)."));
  EXPECT_TRUE(says(with("width_nm_per_mm", 5), "width 5 nm/mm."));
  EXPECT_TRUE(says(with("ppm_per_k_y_q1", 12), "y 12 ppm/K (q1)."));
  EXPECT_TRUE(says(with("nm_per_hpa_pressure", 27), "pressure 27 nm/hPa."));
  EXPECT_TRUE(says(with("nm_per_h", 20), "20 nm/h."));
  EXPECT_TRUE(says(with("arcsec_per_h", 0.5), "0.5 arcsec/h."));
  EXPECT_TRUE(says(with("arcsec_per_k_per_h_rz", 0.5), "rz 0.5 arcsec/(K/h)."));
  EXPECT_TRUE(says(with("arcsec_per_k_q1", 0.5), "0.5 arcsec/K (q1)."));
  EXPECT_TRUE(says(with("further2_time_s", 9030), "further2 time 9030 s."));
  EXPECT_TRUE(says(with("period_nm", 5e6), "period 5 mm."));
  EXPECT_TRUE(says(with("count", 1), "1 row."));
  EXPECT_TRUE(says(with("sag_urad_per_newton_m", 3), "sag 3 urad/(N m)."));
  EXPECT_TRUE(says(with("dead_path_mm", 12), "dead path 12 mm."));
  EXPECT_TRUE(says(with("degree", 3), "degree 3."));
}

TEST(Sentence, ShowsTheEndsOfANarrowIntervalAsTwoNumbers) {
  Finding finding = with("period_nm", 256.004);
  finding.parameters[0].ci90 = Interval{255.98, 256.03};
  EXPECT_TRUE(says(finding, "period 256 nm (90 %: 255.98 to 256.03)."));
}

TEST(Sentence, NamesTheScaleThatDriftsWhereSeveralAxesCould) {
  Finding finding{.cause = "instrument_drift"};
  finding.terms = {effects::Term{{effects::Power{"rx", 1}, effects::Call{"drift", {}, {}}}}};
  EXPECT_THAT(sentence(finding), testing::StartsWith("The scale of rx drifts"));
}

TEST(Sentence, DoesNotSayThatNothingSensedExplainsADriftThatAThermometerExplainsAsWell) {
  Finding finding{.cause = "instrument_drift", .subject = "x"};
  EXPECT_THAT(sentence(finding), testing::HasSubstr("nothing sensed explains it"));
  finding.indistinguishable_from = {"thermal_expansion t05"};
  EXPECT_THAT(sentence(finding), testing::Not(testing::HasSubstr("nothing sensed")));
  EXPECT_THAT(sentence(finding), testing::HasSubstr("cannot tell it from thermal_expansion t05"));
}

TEST(Sentence, NamesThePeriodsThatThePlacesCannotTellFromIt) {
  Finding finding = with("period_nm", 125000);
  finding.parameters[0].aliases = {500e3, 83.3e3};
  EXPECT_THAT(aliases_note(finding),
              testing::HasSubstr("the period 125 um looks the same as 500 um, 83.3 um;"));
  EXPECT_EQ(aliases_note(with("period_nm", 125000)), "");
}

TEST(Sentence, SaysWhichTermsNoFormulaOfTheOutputCanHave) {
  Finding finding = with("period_nm", 256);
  finding.terms = {effects::Term{{effects::Call{"sin", {"q1"}, {{256, "nm"}}}}}};
  EXPECT_THAT(follows_an_output_note(finding, {"q1"}),
              testing::StartsWith("sin(q1, 256 nm) follows q1, which stands on the left"));
  EXPECT_EQ(follows_an_output_note(finding, {"x"}), "");
}

}  // namespace
}  // namespace driftwise::diagnosis
