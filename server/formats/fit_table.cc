#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/effects/effect.h"
#include "server/effects/term_order.h"
#include "server/formats/fit_json.h"

namespace driftwise::formats {
namespace {

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string p_text(double p) {
  if (p < 1e-300) return "<1e-300";
  return p < 1e-4 ? print("%.1e", p) : print("%.4f", p);
}

std::string unit_of(const std::string& symbol, const calibration::Model& model) {
  for (const auto& range : model.domain)
    if (range.channel.symbol == symbol) return range.channel.unit;
  return "";
}

// "mm/mm^2", "mm/degC", "mm/(K/h)": what a coefficient is in. Empty where the term is not in any
// output.
std::string coefficient_unit(const calibration::OutputModel& output, const effects::Term& term,
                             const calibration::Model& model) {
  std::string below;
  int parts = 0;
  for (const auto& factor : term.factors) {
    std::string unit;
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      unit = unit_of(power->symbol, model);
      if (unit.empty() || unit == "1") continue;
      if (power->exponent > 1) unit += "^" + std::to_string(power->exponent);
    } else {
      const auto& call = std::get<effects::Call>(factor);
      const auto* kind = effects::find_effect(call.effect);
      if (kind == nullptr) continue;
      unit = kind->output_unit.empty() ? unit_of(call.symbols.front(), model)
                                       : "(" + kind->output_unit + ")";
      if (unit.empty() || unit == "(1)") continue;
    }
    below += (below.empty() ? "" : " ") + unit;
    ++parts;
  }
  if (below.empty()) return output.channel.unit;
  return output.channel.unit + "/" + (parts > 1 ? "(" + below + ")" : below);
}

std::string pad(const std::string& text, std::size_t width) {
  return text.size() >= width ? text : text + std::string(width - text.size(), ' ');
}

std::string term_rows(const calibration::Model& model, const calibration::OutputModel& output,
                      bool in) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  std::size_t wide = 10, unit_wide = 8;
  for (const auto& report : output.report) {
    if (report.in != in) continue;
    wide = std::max(wide, effects::notation(report.term).size());
    unit_wide = std::max(unit_wide, coefficient_unit(output, report.term, model).size());
  }
  std::string text = "  " + pad(in ? "term" : "left out", wide) + "  " +
                     pad(in ? "unit" : "", unit_wide) +
                     print("%17s %12s %10s %9s", "coefficient", "std error", "t", "p");
  if (in) text += print(" %12s %9s", ("rms " + summary.unit).c_str(), "VIF");
  text += "\n";
  for (const auto& report : output.report) {
    if (report.in != in) continue;
    text += "  " + pad(effects::notation(report.term), wide) + "  " +
            pad(in ? coefficient_unit(output, report.term, model) : "", unit_wide);
    if (!report.note.empty()) {
      text += "  " + report.note + "\n";
      continue;
    }
    text += print("%17.9g %12.3g %10.4g %9s", report.coefficient, report.standard_error, report.t,
                  p_text(report.p).c_str());
    if (in && !report.term.is_constant())
      text += print(" %12.4g %9.3g", report.contribution_rms * summary.factor, report.vif);
    text += "\n";
  }
  return text;
}

std::string accuracy_lines(const calibration::OutputModel& output) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  const auto& accuracy = output.accuracy;
  const char* unit = summary.unit == "1" ? "" : summary.unit.c_str();
  const auto figure = [&](double value) { return print("%.4g %s", value * summary.factor, unit); };
  std::string text = "  RMSE " + figure(accuracy.rmse) +
                     print(", %d degrees of freedom", output.dof) + "; U90 calibration " +
                     figure(accuracy.u90_calibration);
  if (accuracy.u90_validation) text += ", validation " + figure(*accuracy.u90_validation);
  if (accuracy.u90_blocks)
    text += ", by blocks of time " + figure(*accuracy.u90_blocks) +
            print(" (90 %%: %.4g to %.4g)", *accuracy.u90_blocks_low * summary.factor,
                  *accuracy.u90_blocks_high * summary.factor);
  text += "\n";
  text += print("  lag-1 autocorrelation %.2f, %.0f effective rows, condition index %.3g",
                accuracy.lag1_autocorrelation, accuracy.effective_rows, accuracy.condition_index);
  if (accuracy.pure_error)
    text += "; pure error (standard deviation of a repeat) " + figure(*accuracy.pure_error);
  if (accuracy.lack_of_fit_p)
    text += print(", lack of fit F %.3g, p %s", *accuracy.lack_of_fit_f,
                  p_text(*accuracy.lack_of_fit_p).c_str());
  return text + "\n";
}

std::string history_lines(const calibration::OutputModel& output) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  std::string text = print("  %4s %-7s %-24s %9s %12s %6s\n", "step", "", "term", "p",
                           ("rmse " + summary.unit).c_str(), "dof");
  for (const auto& step : output.history)
    text += print("  %4d %-7s %-24s %9s %12.5g %6d\n", step.step, step.action.c_str(),
                  effects::notation(step.term).substr(0, 60).c_str(),
                  step.action == "start" ? "" : p_text(step.p).c_str(), step.rmse * summary.factor,
                  step.dof);
  return text;
}

}  // namespace

std::string fit_table(const calibration::Model& model, const FitTableOptions& options) {
  std::string text = model.formula + "\n";
  text += print("%lld calibration rows, %lld validation, %lld dropped",
                static_cast<long long>(model.lineage.rows_calibration),
                static_cast<long long>(model.lineage.rows_validation),
                static_cast<long long>(model.lineage.rows_dropped));
  if (model.lineage.rows_excluded > 0)
    text += print(", %lld excluded", static_cast<long long>(model.lineage.rows_excluded));
  text += "; ";
  text += model.select == "all"
              ? "all terms, no selection"
              : print("stepwise, enter below %g, remove above %g", model.p_enter, model.p_remove);
  if (model.fit_us > 0) text += print("; %.0f us", model.fit_us);
  text += "\n";
  for (const auto& output : model.outputs) {
    const bool any_out =
        std::ranges::any_of(output.report, [](const auto& report) { return !report.in; });
    text += "\n" + output.channel.name() + "\n" + accuracy_lines(output) +
            term_rows(model, output, true);
    if (options.all && any_out) text += term_rows(model, output, false);
    if (options.history) text += history_lines(output);
  }
  if (!model.warnings.empty()) text += "\n";
  for (const auto& warning : model.warnings) text += "note: " + warning + "\n";
  return text;
}

}  // namespace driftwise::formats
