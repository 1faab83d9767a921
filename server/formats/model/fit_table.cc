#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/calibration/report/accuracy.h"
#include "server/core/text/quantity_text.h"
#include "server/effects/term_order.h"
#include "server/formats/model/coefficient_unit.h"
#include "server/formats/model/fit_json.h"

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
                     print("%17s %12s", "coefficient", "std error");
  if (in) text += print(" %12s", "serial s.e.");
  text += print(" %10s %9s", "t", "p");
  if (in)
    text += print(" %11s %11s %9s", ("rms " + summary.unit).c_str(),
                  ("max " + summary.unit).c_str(), "VIF");
  text += "\n";
  for (const auto& report : output.report) {
    if (report.in != in) continue;
    text += "  " + pad(effects::notation(report.term), wide) + "  " +
            pad(in ? coefficient_unit(output, report.term, model) : "", unit_wide);
    if (!report.note.empty()) {
      text += "  " + report.note + "\n";
      continue;
    }
    text += print("%17.9g %12.3g", report.coefficient, report.standard_error);
    if (in) text += print(" %12.3g", report.standard_error_serial);
    text += print(" %10.4g %9s", report.t, p_text(report.p).c_str());
    if (in && !report.term.is_constant())
      text += print(" %11.4g %11.4g %9.3g", report.contribution_rms * summary.factor,
                    report.contribution_max * summary.factor, report.vif);
    text += "\n";
  }
  return text;
}

std::string accuracy_lines(const calibration::OutputModel& output) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  const auto& accuracy = output.accuracy;
  const char* unit = summary.unit == "1" ? "" : summary.unit.c_str();
  const auto figure = [&](double value) {
    return digits_text(value * summary.factor) + (*unit == '\0' ? "" : " ") + unit;
  };
  // "A90 42.0 nm (mean +24.3 nm, S90 12.8 nm)"
  const auto judged = [&](double mean, double u90, double a90) {
    return "A90 " + figure(a90) + " (mean " +
           mean_text(mean * summary.factor, a90 * summary.factor) + " " + unit + ", S90 " +
           figure(u90) + ")";
  };
  std::string text =
      "  RMSE " + figure(accuracy.rmse) + print(", %d degrees of freedom\n", output.dof) +
      "  calibration rows: " +
      judged(accuracy.mean_calibration, accuracy.u90_calibration, accuracy.a90_calibration) + "\n";
  if (accuracy.a90_validation)
    text += "  validation rows: " +
            judged(*accuracy.mean_validation, *accuracy.u90_validation, *accuracy.a90_validation) +
            "\n";
  for (const auto& [name, of_set] : accuracy.validation_sets)
    text += "    of them " + name + print(", %lld rows: ", static_cast<long long>(of_set.rows)) +
            judged(of_set.mean, of_set.u90, of_set.a90) + "\n";
  if (accuracy.a90_blocks)
    text += "  held-out blocks of time: " +
            judged(*accuracy.mean_blocks, *accuracy.u90_blocks, *accuracy.a90_blocks) +
            ", 90 % interval of A90 " + digits_text(*accuracy.a90_blocks_low * summary.factor) +
            " to " + figure(*accuracy.a90_blocks_high) + "\n";
  text += print("  lag-1 autocorrelation %.2f, %.0f effective rows, condition index %.3g",
                accuracy.lag1_autocorrelation, accuracy.effective_rows, accuracy.condition_index);
  if (accuracy.pure_error)
    text += "; pure error (standard deviation of a repeat) " + figure(*accuracy.pure_error);
  if (accuracy.lack_of_fit_p)
    text += print(", lack of fit F %.3g, p %s", *accuracy.lack_of_fit_f,
                  p_text(*accuracy.lack_of_fit_p).c_str());
  text += "\n";
  if (accuracy.slow_share > 0)
    text += print(
        "  noise in time order: %.0f %% of its variance is slow, over about %.3g rows "
        "(serial s.e. allows for it)\n",
        accuracy.slow_share * 100, accuracy.slow_rows);
  if (accuracy.model_f)
    text += print("  all terms together: F %.4g, p %s", *accuracy.model_f,
                  p_text(*accuracy.model_p).c_str());
  if (accuracy.aic && accuracy.bic)
    text +=
        print("%sAIC %.6g, BIC %.6g", accuracy.model_f ? "; " : "  ", *accuracy.aic, *accuracy.bic);
  return accuracy.model_f || accuracy.aic ? text + "\n" : text;
}

// "best of 8 starts: all (BIC -7312.08), reached by 3; from none -7290.41"
std::string start_lines(const calibration::Model& model, const calibration::OutputModel& output) {
  const auto value = [](const calibration::StartOutcome& start) {
    return start.value ? print("%.7g", *start.value) : std::string("an exact fit");
  };
  const calibration::StartOutcome* won = nullptr;
  for (const auto& start : output.starts)
    if (start.won) won = &start;
  if (won == nullptr) return {};
  const auto alike = std::ranges::count_if(output.starts, [won](const auto& start) {
    return start.value.has_value() == won->value.has_value() &&
           (!start.value || std::abs(*start.value - *won->value) < 1e-6);
  });
  std::string text = print("  best of %zu starts: %s (%s %s), reached by %td", output.starts.size(),
                           won->name.c_str(), model.criterion == "aic" ? "AIC" : "BIC",
                           value(*won).c_str(), alike);
  if (!output.starts.front().won) text += "; from none " + value(output.starts.front());
  return text + "\n";
}

std::string rule_text(const calibration::Model& model) {
  if (model.select == "all") return "all terms, no selection";
  std::string text =
      model.criterion == "p"
          ? print("stepwise, enter below %g, remove above %g", model.p_enter, model.p_remove)
          : "stepwise, " + std::string(model.criterion == "aic" ? "AIC" : "BIC");
  if (model.hierarchy) text += ", with hierarchy";
  if (model.starts > 1)
    text +=
        print(", best of %d starts (seed %lld)", model.starts, static_cast<long long>(model.seed));
  return text;
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
  text += rule_text(model);
  if (model.fit_us > 0) text += print("; %.0f us", model.fit_us);
  text += "\n";
  for (const auto& one : calibration::heading_of(model))
    text += "accuracy (A90) " + accuracy_text(one) + "\n";
  for (const auto& output : model.outputs) {
    const bool any_out =
        std::ranges::any_of(output.report, [](const auto& report) { return !report.in; });
    text += "\n" + output.channel.name() + "\n" + accuracy_lines(output) +
            start_lines(model, output) + term_rows(model, output, true);
    if (options.all && any_out) text += term_rows(model, output, false);
    if (options.history) text += history_lines(output);
  }
  if (!model.warnings.empty()) text += "\n";
  for (const auto& warning : model.warnings) text += "note: " + warning + "\n";
  return text;
}

}  // namespace driftwise::formats
