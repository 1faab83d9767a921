#include "server/formats/diagnosis/diagnosis_html.h"

#include <algorithm>
#include <cmath>

#include "server/core/text/quantity_text.h"
#include "server/diagnosis/report/heading.h"
#include "server/formats/diagnosis/diagnosis_html_parts.h"
#include "server/formats/diagnosis/html_text.h"
#include "server/formats/diagnosis/report_style.h"

namespace driftwise::formats {
namespace {

using diagnosis::Diagnosis;
using diagnosis::OutputSummary;
using diagnosis::Verdict;

// Shape and word first: colour only repeats them.
struct VerdictLook {
  const char* word;
  const char* shape;
};

VerdictLook look_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::adequate:
      return {"Adequate", "<circle class=\"shape-good\" cx=\"18\" cy=\"18\" r=\"14\"/>"};
    case Verdict::extended:
      return {"Extended", "<path class=\"shape-good\" d=\"M18 2 34 18 18 34 2 18z\"/>"};
    case Verdict::unexplained:
      break;
  }
  return {"Unexplained", "<path class=\"shape-warn\" d=\"M18 3 35 33 1 33z\"/>"};
}

std::string causes_text(std::size_t count) {
  if (count == 0) return "no cause";
  return count == 1 ? "one cause" : std::to_string(count) + " causes";
}

std::string summary_text(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::adequate:
      return "nothing beyond noise is supported by these data";
    case Verdict::extended:
      return causes_text(d.findings.size()) + " found, and nothing further remains";
    case Verdict::unexplained:
      break;
  }
  return causes_text(d.findings.size()) +
         " found; structure remains that no entry of the catalogue explains";
}

// The accuracy of one unit: the output with the largest A90 after the findings, its figures, and
// every other output of that unit.
std::string result_text(const Diagnosis& d, const JudgedAccuracy& heads) {
  const std::string unit = html_escaped(heads.unit);
  std::string text = "<div class=\"result\"><p class=\"note\">accuracy (A90) of " +
                     html_escaped(heads.output) + ", " + std::string(in_words(heads.rows)) + "</p>";
  const auto change = [](const ErrorFigures& before, const ErrorFigures& after) {
    return figure_text(before.a90) + " \xE2\x86\x92 " + figure_text(after.a90);
  };
  const ErrorFigures& before = *heads.before;
  text += "<b><span class=\"from\">" + figure_text(before.a90) + " \xE2\x86\x92 </span>" +
          figure_text(heads.figures.a90) + " <span class=\"unit\">" + unit +
          "</span></b><p class=\"note\">mean " + mean_text(before.mean, before.a90) +
          " \xE2\x86\x92 " + mean_text(heads.figures.mean, heads.figures.a90) + ", S90 " +
          digits_text(before.u90) + " \xE2\x86\x92 " + digits_text(heads.figures.u90) + " " + unit +
          "<br>";
  const auto floor = std::ranges::find(d.outputs, heads.output, &OutputSummary::output);
  if (floor != d.outputs.end() && floor->noise_floor_u90)
    text += "noise floor, from repeats: " + sized(*floor->noise_floor_u90, floor->unit);
  else
    text += "nothing was repeated: no noise floor";
  for (const auto& other : diagnosis::judged_accuracies(d)) {
    if (other.output == heads.output || other.unit != heads.unit) continue;
    text += "<br>" + html_escaped(other.output) + ": " + change(*other.before, other.figures) +
            " " + unit + (other.figures.a90 > other.before->a90 ? " (worse)" : "");
  }
  return text + "</p></div>";
}

std::string verdict_section(const Diagnosis& d) {
  const auto look = look_of(d.verdict);
  std::string out =
      "<section class=\"verdict\"><div><div class=\"state\"><svg viewBox=\"0 0 36 36\" "
      "aria-hidden=\"true\">" +
      std::string(look.shape) + "</svg><span>" + look.word + "</span></div><p class=\"note\">" +
      summary_text(d) + "</p></div>";
  for (const auto& one : diagnosis::heading_of(d)) out += result_text(d, one);
  return out + "</section>";
}

std::string head(const DiagnosisPage& page) {
  return "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src '" +
         std::string(report_style_hash()) +
         "'; base-uri 'none'; form-action 'none'\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
         "<meta name=\"generator\" content=\"Driftwise\"><title>" +
         html_escaped(page.title) + "</title><style>" + std::string(report_style()) +
         "</style></head>";
}

}  // namespace

std::string sized(double value, const std::string& unit) {
  return figure_text(value) + " " + html_escaped(unit);
}

std::string diagnosis_html(const Diagnosis& d, const Dataset& dataset, const DiagnosisPage& page) {
  std::string out = head(page) + "<body><main><header><h1>" + html_escaped(page.title) +
                    "</h1><p class=\"note\">" + html_escaped(page.source) +
                    " \xC2\xB7 baseline <code>" + html_escaped(d.baseline_formula) +
                    "</code> \xC2\xB7 " + std::to_string(d.rows_calibration) + " rows searched, " +
                    std::to_string(d.rows_held_out) + " held out</p></header>";
  out += verdict_section(d);
  const auto heading = diagnosis::heading_of(d);
  const OutputSummary* first = nullptr;
  for (const auto& output : d.outputs)
    if (!heading.empty() && output.output == heading.front().output) first = &output;
  if (first != nullptr) out += discrepancy_section(*first, dataset, true);
  out += ranking_section(d);
  for (std::size_t i = 0; i < d.findings.size(); ++i) out += finding_section(d.findings[i], i + 1);
  out += separating_section(d);
  out += rest_section(d);
  out += goes_with_section(d);
  for (const auto& output : d.outputs)
    if (&output != first) out += discrepancy_section(output, dataset, false);
  out += not_testable_section(d);
  out +=
      "<footer><p class=\"note\">A90 = 1.645 \xC3\x97 root mean square of the error, its mean "
      "included; S90 = 1.645 \xC3\x97 standard deviation about the mean. Before and after: "
      "measured minus simulated, in motor coordinates. Held out: rows that took no part in "
      "finding or fitting. p: adjusted for the search over causes and parameters.";
  if (d.extended_formula != d.baseline_formula)
    out += "<br>Extended simulation: <code>" + html_escaped(d.extended_formula) + "</code>";
  return out + "</p></footer></main></body></html>\n";
}

}  // namespace driftwise::formats
