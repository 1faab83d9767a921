#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/core/text/quantity_text.h"
#include "server/effects/term_order.h"
#include "server/formats/model/fit_json.h"
#include "server/formats/model/method_json.h"

namespace driftwise::formats {
namespace {

using identification::Judgement;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

// Figures that are compared stand in one unit: that of the largest of them.
class ComparedFigures {
 public:
  explicit ComparedFigures(const std::string& unit) : summary_(summary_unit(unit)) {}
  void see(const std::optional<double>& value) {
    if (value && std::isfinite(*value))
      largest_ = std::max(largest_, std::abs(*value * summary_.factor));
  }
  std::string text(const std::optional<double>& value) const {
    if (!value) return "-";
    const SizeUnit shown = size_unit({largest_}, summary_.unit);
    return digits_text(*value * summary_.factor * shown.factor) +
           (shown.unit == "1" ? "" : " " + shown.unit);
  }

 private:
  SummaryUnit summary_;
  double largest_ = 0;
};

std::optional<double> a90_of(const std::optional<calibration::HeldOut>& held) {
  return held ? std::optional(held->figures.a90) : std::nullopt;
}

std::string method_heading() {
  return formatted("  %-10s %-8s %10s %12s %12s %12s %12s %12s\n", "method", "", "parameters",
                   "calibration", "validation", "blocks", "groups", "fit time");
}

std::string time_text(double us) {
  if (!(us > 0)) return "-";
  if (us < 1e3) return formatted("%.0f us", us);
  return us < 1e6 ? formatted("%.1f ms", us / 1e3) : formatted("%.2f s", us / 1e6);
}

std::string parameter_rows(const identification::Identification& found) {
  std::string text = formatted("  %-28s %16s %16s %12s %12s\n", "parameter", "nominal",
                               "identified", "change", "std error");
  for (const auto& one : found.parameters) {
    text += formatted("  %-28s %16.9g ", one.parameter.name.c_str(), one.parameter.nominal);
    if (one.free)
      text += formatted("%16.9g %12.4g %12.3g", one.value, one.value - one.parameter.nominal,
                        one.standard_error);
    else
      text += formatted("%16.9g %12s %12s", one.value, "held", "");
    text += (one.note.empty() ? "" : "  " + one.note) + "\n";
  }
  return text;
}

std::string term_rows_of(const identification::Identification& found) {
  std::string text;
  for (std::size_t o = 0; o < found.mechanism->outputs().size() && !found.terms.empty(); ++o) {
    text += "\n  " + found.mechanism->outputs()[o].name() + "\n";
    for (std::size_t j = 0; j < found.terms.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j), column = static_cast<Eigen::Index>(o);
      text += formatted("  %-28s %16.9g %12s %12.3g\n", effects::notation(found.terms[j]).c_str(),
                        found.coefficients(row, column), "", found.standard_errors(row, column));
    }
  }
  return text;
}

std::string note_lines(const Judgement& judgement) {
  std::string text;
  for (const auto& warning : judgement.warnings) text += "note: " + warning + "\n";
  return text;
}

}  // namespace

std::string comparison_table(const std::vector<Judgement>& judgements) {
  std::string text;
  if (judgements.empty()) return text;
  const auto& first = judgements.front();
  text += formatted("%lld calibration rows, %lld validation",
                    static_cast<long long>(first.rows_calibration),
                    static_cast<long long>(first.rows_validation));
  if (first.groups > 0) text += formatted(", %lld groups", static_cast<long long>(first.groups));
  text += "; A90 = 1.645 x rms of the error, mean included\n";
  for (std::size_t o = 0; o < first.outputs.size(); ++o) {
    const Channel& channel = first.outputs[o].channel;
    text += "\n" + channel.name();
    // About the best of them: what a poor model leaves differs from visit to visit as well.
    const identification::OutputFigures* best = nullptr;
    for (const auto& one : judgements)
      for (const auto& output : one.outputs)
        if (output.channel == channel && output.pure_error &&
            (best == nullptr || *output.pure_error < *best->pure_error))
          best = &output;
    ComparedFigures shown(channel.unit);
    for (const auto& one : judgements)
      for (const auto& output : one.outputs)
        if (output.channel == channel)
          for (const auto& figure : {std::optional(output.a90_calibration), output.a90_validation,
                                     a90_of(output.blocks), a90_of(output.groups)})
            shown.see(figure);
    if (best != nullptr)
      text +=
          ": visits of a group agree to " + shown.text(best->pure_error) + " (standard deviation)";
    text += "\n" + method_heading();
    for (const auto& one : judgements) {
      const auto at = std::ranges::find_if(
          one.outputs, [&](const auto& output) { return output.channel == channel; });
      if (at == one.outputs.end()) continue;
      text +=
          formatted("  %-10s %-8s %10d %12s %12s %12s %12s %12s\n",
                    identification::name_of(one.fitted.method).c_str(), "A90", at->parameters,
                    shown.text(at->a90_calibration).c_str(), shown.text(at->a90_validation).c_str(),
                    shown.text(a90_of(at->blocks)).c_str(), shown.text(a90_of(at->groups)).c_str(),
                    time_text(one.fitted.fit_us).c_str());
    }
  }
  if (first.position) {
    text += "\nall outputs together, sqrt(mean |e|^2)\n" + method_heading();
    ComparedFigures shown(first.position->unit);
    for (const auto& one : judgements)
      if (one.position)
        for (const auto& figure : {std::optional(one.position->rms), one.position->rms_validation,
                                   one.position->rms_blocks, one.position->rms_groups})
          shown.see(figure);
    for (const auto& one : judgements) {
      if (!one.position) continue;
      const auto& position = *one.position;
      text += formatted(
          "  %-10s %-8s %10d %12s %12s %12s %12s %12s\n",
          identification::name_of(one.fitted.method).c_str(), "rms", one.fitted.parameters(),
          shown.text(position.rms).c_str(), shown.text(position.rms_validation).c_str(),
          shown.text(position.rms_blocks).c_str(), shown.text(position.rms_groups).c_str(),
          time_text(one.fitted.fit_us).c_str());
    }
    std::optional<double> agree;
    for (const auto& one : judgements)
      if (one.position && one.position->pure_error)
        agree = std::min(agree.value_or(HUGE_VAL), *one.position->pure_error);
    if (agree) text += "  visits of a group agree to " + shown.text(agree) + " rms\n";
  }
  std::string notes;
  for (const auto& one : judgements) notes += note_lines(one);
  return text + (notes.empty() ? "" : "\n" + notes);
}

std::string method_page(const Judgement& judgement, const std::string& formula) {
  std::string text = identification::name_of(judgement.fitted.method);
  if (judgement.fitted.kinematics)
    text += ", " + judgement.fitted.kinematics->mechanism->description().kind;
  text += (formula.empty() ? "" : ": " + formula) + "\n" + comparison_table({judgement});
  if (judgement.fitted.kinematics) {
    const auto& found = *judgement.fitted.kinematics;
    text += formatted("\ncondition of the free parameters %.3g; %d evaluations\n", found.condition,
                      found.evaluations) +
            parameter_rows(found) + term_rows_of(found);
  }
  if (judgement.fitted.linear) text += "\n" + fit_table(*judgement.fitted.linear);
  return text;
}

}  // namespace driftwise::formats
