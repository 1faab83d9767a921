// What was found, how sure, and what was not.

#include <algorithm>
#include <cmath>

#include "server/core/text/quantity_text.h"
#include "server/effects/term_order.h"
#include "server/formats/diagnosis/diagnosis_html_parts.h"
#include "server/formats/diagnosis/html_text.h"
#include "server/formats/diagnosis/svg_plot.h"

namespace driftwise::formats {
namespace {

using diagnosis::Diagnosis;
using diagnosis::Finding;
using diagnosis::FoundParameter;

// 90 % of a profile likelihood with one degree of freedom.
constexpr double kInterval90 = 2.71, kCurveDepth = 12;
constexpr std::size_t kTrajectoryLines = 40;

std::string name_of_finding(const Finding& finding) {
  return finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
}

std::string comma_list(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + html_escaped(word);
  return text;
}

std::string parameters_table(const Finding& finding) {
  std::string rows;
  for (const auto& p : finding.parameters) {
    rows += "<tr><th scope=\"row\">" + html_escaped(p.name) + "</th><td class=\"number\">" +
            figure_text(p.value) + "</td><td class=\"number\">" +
            (p.ci90 ? figure_text(p.ci90->low) + " to " + figure_text(p.ci90->high)
                    : std::string("not bounded by these data")) +
            "</td></tr>";
  }
  for (const auto& output : finding.outputs) {
    rows += "<tr><th scope=\"row\">amplitude, " + html_escaped(output.output) +
            "</th><td class=\"number\">" + sized(output.amplitude, output.unit) +
            "</td><td class=\"number\">" + (output.shown ? "shown" : "not by itself") +
            "</td></tr>";
  }
  if (rows.empty()) return "";
  return "<div class=\"scroll\"><table><thead><tr><th scope=\"col\">parameter</th><th "
         "scope=\"col\" "
         "class=\"number\">value</th><th scope=\"col\" class=\"number\">90 % interval</th></tr>"
         "</thead><tbody>" +
         rows + "</tbody></table></div>";
}

// The curve is a density of evidence: 0 at its best, falling to both sides; the interval is where
// it has not yet lost 2.71.
std::string curve_of(const FoundParameter& p) {
  if (p.curve.size() < 3) return "";
  PlotSeries series{.mark = PlotSeries::Mark::line, .css = "q1"};
  for (const auto& point : p.curve) {
    if (point.below_2lnl > kCurveDepth) continue;  // out of the running
    series.x.push_back(point.value);
    series.y.push_back(-point.below_2lnl);
  }
  PlotSpec spec{.title = "likelihood of " + p.name,
                .description = "highest at " + figure_text(p.value) +
                               (p.ci90 ? ", 90 % between " + figure_text(p.ci90->low) + " and " +
                                             figure_text(p.ci90->high)
                                       : ", not bounded"),
                .height = 200,
                .x = plot_range({&series.x}, 0.0),
                .y = {-kCurveDepth, 0.6},
                .x_marks = {p.value}};
  if (p.ci90) spec.x_band = PlotRange{p.ci90->low, p.ci90->high};
  spec.y.low = std::min(-1.5 * kInterval90, plot_range({&series.y}, 0.02).low);
  return "<div class=\"evidence\"><h3>How well each value of " + html_escaped(p.name) +
         " explains the data</h3><p class=\"note\">2 ln L below the best; dashed: best value; "
         "band: "
         "90 % interval</p>" +
         svg_plot(spec) + "</div>";
}

std::string worth_of(const Finding& finding) {
  std::string out = "<div class=\"worth\">";
  bool any = false;
  for (const auto& output : finding.outputs) {
    if (!output.a90_before || !output.a90_after) continue;
    any = true;
    out += "<p class=\"note\">A90 of " + html_escaped(output.output) +
           " held out</p><b><span class=\"from\">" + figure_text(*output.a90_before) +
           " \xE2\x86\x92 </span>" + sized(*output.a90_after, output.unit) + "</b>";
    if (output.mean_before && output.mean_after && output.u90_before && output.u90_after)
      out += "<p class=\"note\">mean " + mean_text(*output.mean_before, *output.a90_before) +
             " \xE2\x86\x92 " + mean_text(*output.mean_after, *output.a90_after) + ", S90 " +
             digits_text(*output.u90_before) + " \xE2\x86\x92 " + digits_text(*output.u90_after) +
             " " + html_escaped(output.unit) + "</p>";
    if (output.a90_after_ci90)
      out += "<p class=\"note\">90 % interval of A90 " + figure_text(output.a90_after_ci90->low) +
             " to " + sized(output.a90_after_ci90->high, output.unit) + "</p>";
  }
  if (!any) out += "<p class=\"note\">a fault of the data: no gain of its own</p>";
  out += "<p class=\"note\">" + chance_text(finding.p_adjusted) + ", adjusted for the search</p>";
  if (finding.indistinguishable_from.empty())
    out += "<p class=\"note\">no other cause explains it as well</p>";
  else
    out += "<p><strong>These data cannot tell it from:</strong> " +
           comma_list(finding.indistinguishable_from) + "</p>";
  return out + "</div>";
}

}  // namespace

std::string finding_section(const Finding& finding, std::size_t number) {
  std::string sentence = finding.sentence;
  if (!sentence.empty() && sentence[0] >= 'a' && sentence[0] <= 'z' &&
      !sentence.starts_with(finding.subject))
    sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  std::string out = "<section class=\"finding\"><div><h2>" + std::to_string(number) + ". " +
                    html_escaped(sentence) +
                    "</h2><p class=\"note\">Where: " + html_escaped(finding.where) +
                    " \xC2\xB7 cause <code>" + html_escaped(name_of_finding(finding)) +
                    "</code> \xC2\xB7 applies to " +
                    html_escaped(std::string(effects::to_string(finding.applies_to)));
  if (!finding.terms.empty()) {
    out += " \xC2\xB7 adds";
    for (const auto& term : finding.terms)
      out += " <code>" + html_escaped(effects::notation(term)) + "</code>";
  }
  if (!finding.rows.empty()) out += " \xC2\xB7 " + std::to_string(finding.rows.size()) + " rows";
  out += "</p>" + parameters_table(finding);
  for (const auto& parameter : finding.parameters) out += curve_of(parameter);
  return out + "</div>" + worth_of(finding) + "</section>";
}

std::string ranking_section(const Diagnosis& d) {
  if (d.findings.empty()) return "";
  double most = 1;
  for (const auto& finding : d.findings) most = std::max(most, finding.log_likelihood_ratio);
  std::string out =
      "<section><h2>Causes, by how much they explain</h2><div class=\"scroll\"><table><thead><tr>"
      "<th scope=\"col\">cause</th><th scope=\"col\">log-likelihood ratio</th><th scope=\"col\" "
      "class=\"number\">ln L</th><th scope=\"col\" class=\"number\">chance</th><th "
      "scope=\"col\">not told from</th></tr></thead><tbody>";
  for (const auto& finding : d.findings) {
    const auto wide = std::lround(1000 * std::max(0.0, finding.log_likelihood_ratio) / most);
    out += "<tr><th scope=\"row\">" + html_escaped(name_of_finding(finding)) +
           "</th><td><svg class=\"bar\" viewBox=\"0 0 1000 14\" preserveAspectRatio=\"none\" "
           "aria-hidden=\"true\"><rect class=\"bar-back\" width=\"1000\" height=\"14\"/><rect "
           "class=\"bar-front\" width=\"" +
           std::to_string(wide) + "\" height=\"14\"/></svg></td><td class=\"number\">" +
           figure_text(finding.log_likelihood_ratio) + "</td><td class=\"number\">" +
           chance_text(finding.p_adjusted) + "</td><td>" +
           (finding.indistinguishable_from.empty() ? std::string("\xE2\x80\x93")
                                                   : comma_list(finding.indistinguishable_from)) +
           "</td></tr>";
  }
  return out + "</tbody></table></div></section>";
}

std::string rest_section(const Diagnosis& d) {
  std::string out;
  for (const auto& rest : d.left_over)
    out += "<p>Structure remains that no cause of the catalogue explains. It goes with <strong>" +
           html_escaped(rest.goes_with) + "</strong> (" + chance_text(rest.p_adjusted) + ").</p>";
  for (const auto& warning : d.warnings) out += "<p>" + html_escaped(warning) + "</p>";
  return out.empty() ? "" : "<section><h2>What is left, and what to mind</h2>" + out + "</section>";
}

std::string not_testable_section(const Diagnosis& d) {
  if (d.not_testable.empty()) return "";
  std::string out =
      "<section><h2>What these data cannot test</h2><div class=\"scroll\"><table><thead><tr><th "
      "scope=\"col\">cause</th><th scope=\"col\">why</th></tr></thead><tbody>";
  for (const auto& one : d.not_testable)
    out += "<tr><th scope=\"row\"><code>" + html_escaped(one.cause) + "</code></th><td>" +
           html_escaped(one.why) + "</td></tr>";
  return out + "</tbody></table></div></section>";
}

std::string separating_section(const Diagnosis& d) {
  if (!d.separating_experiment) return "";
  const auto& plan = *d.separating_experiment;
  std::string out = "<section><h2>The measurement that would tell them apart</h2><p>" +
                    html_escaped(plan.why) + "</p>";
  if (plan.trajectory_csv.empty()) return out + "</section>";
  out += "<p>";
  if (plan.predicted_power)
    out += "Predicted power <strong>" + figure_text(100 * *plan.predicted_power, 2) +
           " %</strong> \xC2\xB7 ";
  out += "about <strong>" + figure_text(plan.estimated_s / 3600, 2) + " h</strong></p>";
  std::size_t end = 0, lines = 0;
  while (end < plan.trajectory_csv.size() && lines < kTrajectoryLines) {
    const auto next = plan.trajectory_csv.find('\n', end);
    end = next == std::string::npos ? plan.trajectory_csv.size() : next + 1;
    ++lines;
  }
  const bool cut = end < plan.trajectory_csv.size();
  const auto rest = std::count(plan.trajectory_csv.begin() + static_cast<std::ptrdiff_t>(end),
                               plan.trajectory_csv.end(), '\n');
  return out + "<details><summary>Trajectory</summary><pre tabindex=\"0\">" +
         html_escaped(plan.trajectory_csv.substr(0, end)) +
         (cut ? "... and " + std::to_string(rest) + " more" : "") + "</pre></details></section>";
}

}  // namespace driftwise::formats
