// What the discrepancy looks like before and after, and what it goes with.

#include <algorithm>
#include <cmath>

#include "server/formats/diagnosis/diagnosis_html_parts.h"
#include "server/formats/diagnosis/html_text.h"
#include "server/formats/diagnosis/svg_plot.h"

namespace driftwise::formats {
namespace {

using diagnosis::OutputSummary;

constexpr double kSecondsPerHour = 3600;

// Across the page: what is plotted against.
struct Across {
  std::string words;  // "hours since start"
  std::vector<double> values;
};

Across time_across(const Dataset& dataset) {
  Across across{"hours since start", {}};
  if (dataset.time_s.empty()) {
    across.words = "row";
    for (std::size_t i = 0; i < dataset.rows; ++i)
      across.values.push_back(static_cast<double>(i + 1));
    return across;
  }
  for (const double time_s : dataset.time_s)
    across.values.push_back((time_s - dataset.time_s.front()) / kSecondsPerHour);
  return across;
}

bool moves(const std::vector<double>& values) {
  const auto finite = [](double value) { return std::isfinite(value); };
  const auto first = std::ranges::find_if(values, finite);
  return first != values.end() && std::ranges::any_of(values, [&](double value) {
           return std::isfinite(value) && value != *first;
         });
}

// The pose axis of the same number as the output: x for q1, y for q2; else the first that moves.
Across position_across(const Dataset& dataset, const std::string& output) {
  static const std::vector<std::string> axes{"x", "y", "z"};
  std::vector<std::string> wanted;
  if (output.size() == 2 && output[0] == 'q' && output[1] >= '1' && output[1] <= '3')
    wanted.push_back(axes[static_cast<std::size_t>(output[1] - '1')]);
  wanted.insert(wanted.end(), {"x", "y", "z", "q1"});
  for (const auto& symbol : wanted) {
    const auto* column = dataset.find(symbol);
    if (column != nullptr && moves(column->values))
      return {symbol + ", " + column->channel.unit, column->values};
  }
  return {};
}

std::string colour_of(const std::string& output) {
  return output == "q1" || output == "q2" || output == "q3" ? output : "q1";
}

std::string one_plot(const OutputSummary& output, const Dataset& dataset, const Across& across,
                     bool after, PlotRange scale) {
  const auto& values = after ? output.after : output.before;
  const double a90 = after ? output.a90_calibration_after : output.a90_calibration_before;
  PlotSeries calibration{.mark = PlotSeries::Mark::points, .css = colour_of(output.output)};
  PlotSeries validation{.mark = PlotSeries::Mark::diamonds, .css = "s6"};
  for (std::size_t i = 0; i < std::min(values.size(), across.values.size()); ++i) {
    auto& series = dataset.set_of(i) == PointSet::validation ? validation : calibration;
    series.x.push_back(across.values[i]);
    series.y.push_back(values[i]);
  }
  const std::string when = after ? "after" : "before";
  PlotSpec spec{.title = output.output + " " + when + ": measured minus simulated, " + output.unit +
                         ", against " + across.words,
                .description = std::to_string(values.size()) + " rows, A90 " + figure_text(a90) +
                               " " + output.unit + " " + when,
                .x = plot_range({&across.values}, 0.01),
                .y = scale,
                .series = {std::move(calibration), std::move(validation)},
                .band = PlotRange{-a90, a90},
                .zero_line = true};
  return "<div><h3>" + std::string(after ? "After" : "Before") + ": \xC2\xB1" +
         sized(a90, output.unit) + "</h3><p class=\"note\">" +
         (after ? "same scale"
                : html_escaped(output.unit) + " against " + html_escaped(across.words) +
                      "; band = A90 of the rows searched") +
         "</p>" + svg_plot(spec) + "</div>";
}

std::string pair_of(const OutputSummary& output, const Dataset& dataset, const Across& across) {
  if (across.values.empty()) return "";
  const auto scale = plot_range({&output.before, &output.after}, 0.03, true);
  return "<div class=\"pair\">" + one_plot(output, dataset, across, false, scale) +
         one_plot(output, dataset, across, true, scale) + "</div>";
}

std::string keys(const Dataset& dataset, const std::string& output) {
  if (dataset.set.empty()) return "";
  return "<p class=\"note\"><span class=\"key\"><svg viewBox=\"0 0 14 14\" aria-hidden=\"true\">"
         "<path class=\"points " +
         colour_of(output) +
         "\" d=\"M7 7h0\"/></svg>calibration</span><span class=\"key\"><svg viewBox=\"0 0 14 14\" "
         "aria-hidden=\"true\"><path class=\"diamonds s6\" d=\"M4 7l3-3 3 3-3 "
         "3z\"/></svg>validation</span></p>";
}

std::string bar_row(const std::string& name, double share) {
  const int wide = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * 1000));
  return "<tr><td>" + html_escaped(name) +
         "</td><td><svg class=\"bar\" viewBox=\"0 0 1000 14\" preserveAspectRatio=\"none\" "
         "aria-hidden=\"true\"><rect class=\"bar-back\" width=\"1000\" height=\"14\"/>"
         "<rect class=\"bar-front\" width=\"" +
         std::to_string(wide) + "\" height=\"14\"/></svg></td><td class=\"number\">" +
         figure_text(100 * share, 2) + " %</td></tr>";
}

}  // namespace

std::string discrepancy_section(const OutputSummary& output, const Dataset& dataset, bool opened) {
  const std::string heading =
      "Discrepancy of " + html_escaped(output.output) + ", measured minus simulated";
  const std::string plots = pair_of(output, dataset, time_across(dataset)) +
                            pair_of(output, dataset, position_across(dataset, output.output)) +
                            keys(dataset, output.output);
  if (opened) return "<section><h2>" + heading + "</h2>" + plots + "</section>";
  return "<section><h2>" + heading + "</h2><p class=\"note\">A90 " +
         figure_text(output.a90_calibration_before) + " \xE2\x86\x92 " +
         sized(output.a90_calibration_after, output.unit) +
         " on the rows searched</p><details><summary>Show " + html_escaped(output.output) +
         "</summary>" + plots + "</details></section>";
}

std::string goes_with_section(const diagnosis::Diagnosis& d) {
  std::string out;
  for (const auto& output : d.outputs) {
    if (output.explained_by.empty()) continue;
    out += "<table class=\"bars\"><caption>" + html_escaped(output.output) +
           ", before: share of its variance that each variable by itself could carry</caption>";
    std::size_t shown = 0;
    for (const auto& one : output.explained_by)
      if (one.share >= 0.01 && shown++ < 8) out += bar_row(one.variable, one.share);
    out += "</table>";
  }
  if (out.empty()) return "";
  return "<section><h2>What the discrepancy goes with</h2>" + out + "</section>";
}

}  // namespace driftwise::formats
