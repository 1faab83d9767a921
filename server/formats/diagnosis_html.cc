#include "server/formats/diagnosis_html.h"

#include <algorithm>
#include <cmath>

#include "server/formats/diagnosis_html_parts.h"
#include "server/formats/html_text.h"
#include "server/formats/report_style.h"

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

// The output that the findings improve most, by ratio; the first where none is judged.
const OutputSummary* headline(const Diagnosis& d) {
  const OutputSummary* best = d.outputs.empty() ? nullptr : &d.outputs.front();
  double best_ratio = 1;
  for (const auto& output : d.outputs) {
    if (!output.u90_validation_before || !output.u90_validation_after) continue;
    const double ratio = *output.u90_validation_after / *output.u90_validation_before;
    if (ratio < best_ratio) {
      best = &output;
      best_ratio = ratio;
    }
  }
  return best;
}

// Of the last finding that changed this output: it was judged with all of them in.
std::string result_text(const Diagnosis& d, const OutputSummary& output) {
  const bool judged = output.u90_validation_before && output.u90_validation_after;
  std::string text = "<div class=\"result\"><p class=\"note\">accuracy (U90) of " +
                     html_escaped(output.output) +
                     (judged ? " on rows held out" : " on the rows it was fitted to") + "</p>";
  const double before = judged ? *output.u90_validation_before : output.u90_calibration_before;
  const double after = judged ? *output.u90_validation_after : output.u90_calibration_after;
  text += "<b><span class=\"from\">" + figure_text(before) + " \xE2\x86\x92 </span>" +
          figure_text(after) + " <span class=\"unit\">" + html_escaped(output.unit) +
          "</span></b><p class=\"note\">";
  if (output.noise_floor_u90)
    text += "noise floor, from repeats: " + sized(*output.noise_floor_u90, output.unit);
  else
    text += "nothing was repeated: no noise floor";
  for (const auto& other : d.outputs) {
    if (&other == &output || !other.u90_validation_before || !other.u90_validation_after) continue;
    text += "<br>" + html_escaped(other.output) + ": " + figure_text(*other.u90_validation_before) +
            " \xE2\x86\x92 " + sized(*other.u90_validation_after, other.unit);
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
  if (const auto* output = headline(d)) out += result_text(d, *output);
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
  const auto* first = headline(d);
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
      "<footer><p class=\"note\">U90 = 1.645 \xC3\x97 standard deviation of the error. Before and "
      "after: "
      "measured minus simulated, in motor coordinates. Held out: rows that took no part in "
      "finding or fitting. p: adjusted for the search over causes and parameters.";
  if (d.extended_formula != d.baseline_formula)
    out += "<br>Extended simulation: <code>" + html_escaped(d.extended_formula) + "</code>";
  return out + "</p></footer></main></body></html>\n";
}

}  // namespace driftwise::formats
