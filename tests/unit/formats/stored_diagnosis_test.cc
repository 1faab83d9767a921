// What the daemon keeps of a diagnosis and of a correction comes back as it was.

#include "server/formats/diagnosis/stored_diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/effects/term_order.h"
#include "server/formats/diagnosis/amendment_json.h"
#include "server/formats/formula/formula.h"

namespace driftwise::formats {
namespace {

namespace dx = driftwise::diagnosis;

dx::Diagnosis lag_and_outliers() {
  dx::Diagnosis d;
  d.verdict = dx::Verdict::unexplained;
  d.baseline_formula = "q ~ x";
  d.extended_formula = "q ~ x + lag(t07, 1830 s)";
  d.rows_calibration = 560;
  d.rows_held_out = 448;
  d.judged_on = JudgedRows::blocks;
  d.nulls = 199;
  dx::OutputSummary q1;
  q1.output = "q1";
  q1.unit = "nm";
  q1.u90 = 84.123456789012345;
  q1.u90_calibration_before = 84.1;
  q1.u90_calibration_after = 12.5;
  q1.u90_validation_before = 85.0;
  q1.mean_validation_before = -7.5;
  q1.a90_validation_before = 86.0;
  q1.a90 = 84.5;
  q1.noise_white_sd = 7.5;
  q1.noise_slow_sd = 3.25;
  q1.noise_tau_s = 600;
  q1.explained_by = {{"t07", 0.41}, {"time", 0.1}};
  q1.before = {1, std::nan(""), 3};
  q1.after = {0.5, std::nan(""), -0.25};
  d.outputs = {q1};
  dx::Finding lag;
  lag.cause = "thermal_lag";
  lag.subject = "t07";
  lag.where = "robot";
  lag.parameters = {{"tau_s", 1830, dx::Interval{1740, 1925}, {{1700, 6.1}, {1830, 0}}}};
  lag.terms = {*parse_term("lag(t07, 1830 s)")};
  lag.p_adjusted = 0.001;
  lag.log_likelihood_ratio = 412;
  lag.indistinguishable_from = {"self_heating q1"};
  lag.outputs = {
      {"q1", "nm", 51.0, 800.5, true, 85.0, 12.0, dx::Interval{11, 13}, {-1.5e-4}, 60.0, 3.5}};
  lag.sentence = "the structure follows t07 with a delay of 1830 s";
  dx::Finding outliers;
  outliers.cause = "outliers";
  outliers.where = "data";
  outliers.applies_to = effects::AppliesTo::dataset;
  outliers.rows = {17, 18, 400};
  d.findings = {lag, outliers};
  d.not_testable = {{"abbe_offset", "no tilt channel"}};
  d.left_over = {{"line", 0.002}};
  d.separating_experiment =
      dx::SeparatingExperiment{"it tells a lag from heat", 0.98, "q1_mm\n0\n", 7200};
  d.warnings = {"sensor t03 is frozen"};
  return d;
}

TEST(StoredDiagnosis, ComesBackAsItWas) {
  const auto d = lag_and_outliers();
  const auto text = write_stored_diagnosis(d);
  const auto back = read_stored_diagnosis(text);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->verdict, d.verdict);
  EXPECT_EQ(back->outputs[0].u90, d.outputs[0].u90);
  EXPECT_EQ(back->outputs[0].u90_validation_after, std::nullopt);
  EXPECT_EQ(back->outputs[0].mean_validation_before, -7.5);
  EXPECT_EQ(back->outputs[0].a90_validation_before, 86.0);
  EXPECT_EQ(back->outputs[0].a90, 84.5);
  EXPECT_EQ(back->judged_on, JudgedRows::blocks);
  EXPECT_EQ(back->outputs[0].explained_by[0].variable, "t07");
  ASSERT_EQ(back->findings.size(), 2u);
  const auto& lag = back->findings[0];
  EXPECT_EQ(effects::notation(lag.terms[0]), "lag(t07, 1830 s)");
  EXPECT_EQ(lag.parameters[0].ci90->high, 1925);
  EXPECT_EQ(lag.parameters[0].curve[0].below_2lnl, 6.1);
  EXPECT_EQ(lag.outputs[0].coefficients, d.findings[0].outputs[0].coefficients);
  EXPECT_EQ(lag.outputs[0].u90_after_ci90->low, 11);
  EXPECT_EQ(lag.outputs[0].correction_rms, 60);
  EXPECT_EQ(lag.outputs[0].correction_u90, 3.5);
  EXPECT_EQ(lag.indistinguishable_from, d.findings[0].indistinguishable_from);
  EXPECT_EQ(back->findings[1].applies_to, effects::AppliesTo::dataset);
  EXPECT_EQ(back->findings[1].rows, d.findings[1].rows);
  EXPECT_EQ(back->separating_experiment->predicted_power, 0.98);
  EXPECT_EQ(back->warnings, d.warnings);
  EXPECT_EQ(write_stored_diagnosis(*back), text);  // and once more: nothing was lost on the way
}

TEST(StoredDiagnosis, SaysWhereADamagedTextIsDamaged) {
  auto text = write_stored_diagnosis(lag_and_outliers());
  const std::string good = R"("applies_to":"robot")", bad = R"("applies_to":"robt!")";
  text.replace(text.find(good), good.size(), bad);
  const auto back = read_stored_diagnosis(text);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().code, ErrorCode::data_loss);
  EXPECT_NE(back.error().message.find("findings[0].applies_to"), std::string::npos)
      << back.error().message;
}

// A person's editor, half a page, another program: an error, never a crash.
TEST(StoredDiagnosis, AnyDamageIsAnError) {
  const auto whole = write_stored_diagnosis(lag_and_outliers());
  const auto rows = write_discrepancy_rows(
      {{0, 1}, {0, 1}, {1, 1}, {{"x", "mm", {1, 2}}}, {{"q1", "nm", {1, 2}, {3, 4}}}});
  std::mt19937 random(20261121);
  for (int i = 0; i < 3000; ++i) {
    auto text = i % 2 ? whole : rows;
    const int hits = 1 + static_cast<int>(random() % 4);
    for (int hit = 0; hit < hits; ++hit)
      text[random() % text.size()] = static_cast<char>(random() % 256);
    if (i % 5 == 0) text.resize(random() % text.size());
    static_cast<void>(read_stored_diagnosis(text));
    static_cast<void>(read_discrepancy_rows(text));
    static_cast<void>(read_amendment_json(text));
  }
}

TEST(DiscrepancyRows, UnevenOrEndlesslyNestedOnesAreRefused) {
  const DiscrepancyRows good{
      {0, 1}, {0, 1}, {1, 1}, {{"x", "mm", {1, 2}}}, {{"q1", "nm", {1, 2}, {3, 4}}}};
  ASSERT_TRUE(read_discrepancy_rows(write_discrepancy_rows(good)));
  auto short_sets = good, short_column = good, short_after = good, no_line = good;
  short_sets.validation.pop_back();
  short_column.variables[0].values.pop_back();
  short_after.outputs[0].after.pop_back();
  no_line.line[1] = 1e300;
  for (const auto& rows : {short_sets, short_column, short_after, no_line}) {
    const auto back = read_discrepancy_rows(write_discrepancy_rows(rows));
    ASSERT_FALSE(back);
    EXPECT_EQ(back.error().reason, "BAD_ROWS");
    EXPECT_EQ(back.error().code, ErrorCode::data_loss);
  }
  // An array in an array in an array ...: the stack of whoever reads them by calling himself.
  EXPECT_EQ(read_discrepancy_rows(std::string(1'000'000, '\x81')).error().reason, "BAD_ROWS");
}

TEST(DiscrepancyRows, HoldWhatAPlotNeeds) {
  Dataset data;
  data.rows = 3;
  data.time_s = {0, 10, 20};
  data.set = {PointSet::calibration, PointSet::validation, PointSet::calibration};
  data.line = {1, 1, 2};
  data.columns = {{{"x", "mm"}, {0, 1, 2}}, {{"force", "N"}, {5, 5, 5}}};
  const auto rows = discrepancy_rows(data, lag_and_outliers());
  ASSERT_EQ(rows.variables.size(), 1u);  // the force does not vary
  EXPECT_EQ(rows.variables[0].symbol, "x");
  const auto back = read_discrepancy_rows(write_discrepancy_rows(rows));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->time_s, data.time_s);
  EXPECT_EQ(back->validation, (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(back->outputs[0].before[0], 1);
  EXPECT_TRUE(std::isnan(back->outputs[0].after[1]));
  EXPECT_EQ(discrepancy_rows(data, lag_and_outliers(), 2).time_s, (std::vector<double>{0, 20}));
}

TEST(AmendmentJson, KeepsTheDriftOfAnAngleWithItsUncertaintyAndItsSource) {
  correction::DataAmendment amendment;
  amendment.angles = {{"ry", {*parse_term("t05")}, {0.8}, {0.05}, "41 returns to zero", {}, {}}};
  const std::string json = write_amendment_json(amendment);
  const auto back = read_amendment_json(json);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(*back, amendment);
  const auto at = json.find("0.05");
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(read_amendment_json(std::string(json).replace(at, 4, "-0.5")).error().reason,
            "BAD_CORRECTION");
  EXPECT_EQ(write_amendment_json({}).find("angles"), std::string::npos)
      << "other corrections keep their text";
}

TEST(AmendmentJson, ComesBackAsItWas) {
  correction::DataAmendment amendment;
  amendment.shifts = {{"x",
                       {*parse_term("sin(x, 316.4 nm)"), *parse_term("ry")},
                       {5.25e-6, -1e-3},
                       {RunId{3}, RunId{4}},
                       {1'790'000'000'000'000'000}}};
  amendment.shifts.push_back({"ma.z", {*parse_term("ma.rx")}, {1e-3}, {}, {}, "touch"});
  amendment.splits = {{{3}, 25}};
  amendment.sensors = {{{4}, "t07"}};
  const auto back = read_amendment_json(write_amendment_json(amendment));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(*back, amendment);
  EXPECT_EQ(read_amendment_json(R"({"schema":"driftwise.model.v1"})").error().reason,
            "BAD_CORRECTION");
}

}  // namespace
}  // namespace driftwise::formats
