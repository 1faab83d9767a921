#include "server/formats/diagnosis/diagnosis_html.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include "server/diagnosis/report/heading.h"
#include "server/formats/diagnosis/html_text.h"
#include "server/formats/diagnosis/report_style.h"
#include "server/formats/diagnosis/svg_plot.h"

namespace driftwise::formats {
namespace {

struct Diagnosed {
  Dataset dataset;
  diagnosis::Diagnosis diagnosis;
};

// A lag of t07 and what is left of it, made up; names that would break a careless page.
Diagnosed diagnosed(std::size_t rows = 700) {
  Diagnosed made;
  auto& data = made.dataset;
  data.rows = rows;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0, 9);
  diagnosis::OutputSummary q1;
  q1.output = "q1";
  q1.unit = "nm";
  q1.u90 = 164;
  q1.noise_floor_u90 = 13.2;
  q1.u90_calibration_before = 112;
  q1.u90_calibration_after = 15.1;
  q1.u90_validation_before = 118;
  q1.u90_validation_after = 16.4;
  q1.a90_calibration_before = 112;
  q1.a90_calibration_after = 15.1;
  q1.mean_validation_before = -11;
  q1.mean_validation_after = 6.2;
  q1.a90_validation_before = 119.5;
  q1.a90_validation_after = 19.3;
  q1.explained_by = {{"t07", 0.62}, {"time", 0.21}, {"x", 0.03}};
  for (std::size_t i = 0; i < rows; ++i) {
    const double time_s = 14.3 * static_cast<double>(i);
    data.time_s.push_back(time_s);
    data.set.push_back(i % 3 == 2 ? PointSet::validation : PointSet::calibration);
    const double x = -4 + 0.5 * static_cast<double>(i % 17);
    data.columns[0].values.push_back(x);
    data.columns[1].values.push_back(x);
    const double left = noise(random);
    q1.before.push_back(95 * std::sin(time_s / 2200) + left);
    q1.after.push_back(left);
  }
  auto& d = made.diagnosis;
  d.verdict = diagnosis::Verdict::extended;
  d.baseline_formula = "q1 ~ x + x^2 + t05";
  d.extended_formula = "q1 ~ x + x^2 + t05 + lag(t07, 1830 s)";
  d.outputs = {q1};
  d.rows_calibration = rows - rows / 3;
  d.rows_held_out = rows / 3;
  diagnosis::Finding finding;
  finding.cause = "thermal_lag";
  finding.subject = "t07";
  finding.where = "robot";
  diagnosis::FoundParameter tau;
  tau.name = "tau_s";
  tau.value = 1830;
  tau.ci90 = diagnosis::Interval{1740, 1925};
  for (double value = 1300; value < 2500; value += 20)
    tau.curve.push_back({value, std::pow((value - 1830) / 57, 2)});
  finding.parameters = {tau};
  finding.terms = {{{effects::Call{"lag", {"t07"}, {{1830, "s"}}}}}};
  finding.p_adjusted = 0.0004;
  finding.log_likelihood_ratio = 412;
  finding.indistinguishable_from = {"self_heating q1"};
  diagnosis::FindingOutput out;
  out.output = "q1";
  out.unit = "nm";
  out.amplitude = 67;
  out.shown = true;
  out.u90_before = 118;
  out.u90_after = 16.4;
  out.u90_after_ci90 = diagnosis::Interval{14.9, 18.2};
  out.mean_before = -11;
  out.mean_after = 6.2;
  out.a90_before = 119.5;
  out.a90_after = 19.3;
  out.a90_after_ci90 = diagnosis::Interval{17.2, 21.6};
  finding.outputs = {out};
  finding.sentence = "the robot follows t07 with a delay: tau 1830 s (90 % 1740 to 1925 s)";
  d.findings = {finding};
  d.not_testable = {{"abbe_offset", "no tilt channel"},
                    {"force_compliance", "no force_N that varies"}};
  d.warnings = {"<script>alert('&')</script> is no sensor"};
  d.separating_experiment = diagnosis::SeparatingExperiment{
      .why = "motion on and off at constant room temperature tells a lag from heat of the motor",
      .predicted_power = 0.98,
      .trajectory_csv = "q1_mm,set,line,zero\n0,calibration,0,1\n1,calibration,0,0\n",
      .estimated_s = 7200};
  return made;
}

std::string page_of(const Diagnosed& made) {
  return diagnosis_html(made.diagnosis, made.dataset, {"Diagnosis of run 17", "run 17"});
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(DiagnosisPage, StandsByItself) {
  const auto page = page_of(diagnosed());
  for (const char* foreign :
       {"http:", "https:", "src=", "url(", "@import", "<script", "style=\"", "onload", "href="})
    EXPECT_EQ(page.find(foreign), std::string::npos) << foreign;
  EXPECT_NE(page.find("default-src 'none'; style-src '" + std::string(report_style_hash()) + "'"),
            std::string::npos);
  if (const char* keep = std::getenv("DRIFTWISE_KEEP_PAGE")) std::ofstream(keep) << page;
}

TEST(DiagnosisPage, SaysWhatADiagnosisSays) {
  const auto page = page_of(diagnosed());
  for (const char* said :
       {"Extended", "The robot follows t07 with a delay", "self_heating q1", "no tilt channel",
        "17.2 to 21.6", "accuracy (A90) of q1, validation rows", "mean -11", "lag(t07, 1830 s)",
        "Predicted power <strong>98 %", "p &lt; 0.001", "&lt;script&gt;alert(&#39;&amp;&#39;)"})
    EXPECT_NE(page.find(said), std::string::npos) << said;
}

// q1 got better, q2 worse, and q2 is the worse one now: it heads the page, before and after.
TEST(DiagnosisPage, IsHeadedByTheWorstOutput) {
  auto made = diagnosed();
  auto q2 = made.diagnosis.outputs[0];
  q2.output = "q2";
  q2.u90_validation_before = q2.a90_validation_before = 13.5;
  q2.u90_validation_after = q2.a90_validation_after = 21.0;
  made.diagnosis.outputs.push_back(q2);
  const auto page = page_of(made);
  EXPECT_NE(page.find("accuracy (A90) of q2, validation rows"), std::string::npos);
  EXPECT_EQ(page.find("accuracy (A90) of q1"), std::string::npos);
  EXPECT_EQ(diagnosis::outputs_made_worse(made.diagnosis),
            std::vector<std::string>{"q2: 13.5 -> 21 nm"});
}

TEST(DiagnosisPage, EveryPlotHasATextAndEveryTagIsClosed) {
  const auto page = page_of(diagnosed());
  EXPECT_GE(count_of(page, "<svg role=\"img\""), 5U);  // before, after twice; a likelihood
  EXPECT_EQ(count_of(page, "<svg "),
            count_of(page, "role=\"img\"") + count_of(page, "aria-hidden"));
  EXPECT_EQ(count_of(page, "role=\"img\""), count_of(page, "<desc>"));
  for (const std::string tag :
       {"section", "div", "table", "tr", "td", "th", "svg", "p", "details", "pre", "main", "b"})
    EXPECT_EQ(count_of(page, "<" + tag + ">") + count_of(page, "<" + tag + " "),
              count_of(page, "</" + tag + ">"))
        << tag;
}

TEST(DiagnosisPage, StaysSmallForAWeekendOfRows) {
  EXPECT_LT(page_of(diagnosed(216'000)).size(), 400'000U);
}

TEST(DiagnosisPage, WorksWithoutTimesAndWithNothingFound) {
  auto made = diagnosed(40);
  made.dataset.time_s.clear();
  made.diagnosis.findings.clear();
  made.diagnosis.separating_experiment.reset();
  made.diagnosis.verdict = diagnosis::Verdict::adequate;
  const auto page = page_of(made);
  EXPECT_NE(page.find("Adequate"), std::string::npos);
  EXPECT_NE(page.find("against row"), std::string::npos);
  made.diagnosis.outputs.clear();
  EXPECT_NE(page_of(made).find("</html>"), std::string::npos);
}

// The browser would refuse a style sheet that does not match: sha256sum is the outside opinion.
TEST(ReportStyle, MatchesItsHash) {
  const std::string file = testing::TempDir() + "report_style.css";
  std::ofstream(file, std::ios::binary) << report_style();
  std::FILE* pipe = popen(("sha256sum " + file + " | cut -c1-64").c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 80> hex{};
  ASSERT_NE(std::fgets(hex.data(), hex.size(), pipe), nullptr);
  pclose(pipe);
  std::string bytes;
  for (std::size_t i = 0; i < 64; i += 2)
    bytes += static_cast<char>(std::stoi(std::string(hex.data() + i, 2), nullptr, 16));
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64 = "sha256-";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      base64 += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  EXPECT_EQ(base64, report_style_hash());
}

TEST(FigureText, ShowsWhatThePersonNeeds) {
  EXPECT_EQ(figure_text(84.231), "84.2");
  EXPECT_EQ(figure_text(-0.0304),
            "\xE2\x88\x92"
            "0.0304");
  EXPECT_EQ(figure_text(18301.4),
            "18\xE2\x80\x89"
            "301");
  EXPECT_EQ(figure_text(1830), "1830");
  EXPECT_EQ(figure_text(std::nan("")), "\xE2\x80\x93");
  EXPECT_EQ(figure_text(-0.0), "0.00");
}

TEST(PlotTicks, AreLabelledAlike) {
  PlotSpec spec;
  spec.x = {0, 3};
  spec.y = {-0.3, 0.3};
  const auto svg = svg_plot(spec);
  for (const char* label : {">0.5<", ">1.0<", ">2.5<", ">0.2<", ">0<"})
    EXPECT_NE(svg.find(label), std::string::npos) << label;
}

TEST(PlotTicks, AreRoundAndInside) {
  EXPECT_EQ(plot_ticks({0, 10}, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(plot_ticks({-130, 130}, 5), (std::vector<double>{-100, 0, 100}));
  EXPECT_TRUE(plot_ticks({3, 3}, 5).empty());
}

}  // namespace
}  // namespace driftwise::formats
