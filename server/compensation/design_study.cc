#include "server/compensation/design_study.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "server/calibration/design/predict.h"
#include "server/compensation/declared_errors.h"
#include "server/core/data/accuracy.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::compensation {
namespace {

struct Asked {
  const DesignQuantity* quantity = nullptr;
  double value = 0;
};

std::string names_of(const std::vector<DesignQuantity>& quantities) {
  std::string text;
  for (const auto& one : quantities) text += (text.empty() ? "" : ", ") + one.name();
  return text;
}

Result<void> read_change(const std::string& text, const std::vector<DesignQuantity>& quantities,
                         std::vector<Asked>& asked) {
  const auto equals = text.find('=');
  const std::string name = text.substr(0, equals);
  std::vector<const DesignQuantity*> meant;
  for (const auto& one : quantities)
    if (one.name() == name || "*." + one.key == name) meant.push_back(&one);
  if (equals == std::string::npos || meant.empty())
    return fail(ErrorCode::invalid_argument, reasons::kUnknownName,
                "change: found " + shown(text) + ", expected NAME=VALUE with one of: " +
                    names_of(quantities) + "; *.KEY=VALUE changes every one with that key");
  double value = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + equals + 1, last, value);
  for (const auto* one : meant) {
    if (error != std::errc() || end != last || !(value >= one->low && value <= one->high))
      return fail(ErrorCode::invalid_argument, reasons::kBadNumber,
                  "change: found " + shown(text) + ", expected a number from " +
                      number_text(one->low) + " to " + number_text(one->high));
    const auto same = std::ranges::find(asked, one, &Asked::quantity);
    if (same == asked.end())
      asked.push_back({one, value});
    else
      same->value = value;
  }
  return {};
}

// Rows as another material would have shown them: a thermometer that moves by factor times as much
// about its mean makes the model's terms of it give what another expansion would.
Dataset with_expansion(const Dataset& rows, const std::map<std::string, double>& factors) {
  Dataset out = rows;
  for (auto& column : out.columns) {
    const auto factor = factors.find(column.channel.symbol);
    if (factor == factors.end()) continue;
    double sum = 0, count = 0;
    for (const double value : column.values)
      if (!is_missing(value)) sum += value, count += 1;
    for (double& value : column.values)
      if (!is_missing(value)) value = sum / count + factor->second * (value - sum / count);
  }
  return out;
}

// Size of the temperature terms over the rows, nm: rms about their mean.
Result<double> thermal_rms_nm(const calibration::OutputModel& output, const Dataset& rows,
                              const std::map<std::string, double>& factors) {
  std::map<std::string, double> none = factors;
  for (auto& [symbol, factor] : none) factor = 0;
  DRIFTWISE_TRY(const auto with, calibration::predict(with_expansion(rows, factors), output));
  DRIFTWISE_TRY(const auto without, calibration::predict(with_expansion(rows, none), output));
  std::vector<double> thermal;
  for (Eigen::Index i = 0; i < with.size(); ++i)
    if (std::isfinite(with[i] - without[i])) thermal.push_back(with[i] - without[i]);
  const auto figures = error_figures(thermal);
  return figures.u90 / kSigmaToU90 * summary_unit(output.channel.unit).factor;
}

// The rows of another design would scatter by its instruments; what the robot adds to them stays.
void change_scatter(calibration::Model& model, const CellDescription& before,
                    const CellDescription& after) {
  const auto& measured_by = model.lineage.measured_by;
  for (auto& output : model.outputs) {
    const double scatter_nm2 = std::pow(output.accuracy.rmse * nm_per_unit(output.channel), 2);
    const double noise_nm2 = instrument_noise_nm2(output, before, measured_by),
                 other_nm2 = instrument_noise_nm2(output, after, measured_by);
    if (noise_nm2 == other_nm2 || scatter_nm2 == 0) continue;
    const double changed_nm2 = scatter_nm2 > noise_nm2 ? scatter_nm2 - noise_nm2 + other_nm2
                                                       : scatter_nm2 * other_nm2 / noise_nm2;
    const double ratio = changed_nm2 / scatter_nm2;
    output.accuracy.rmse *= std::sqrt(ratio);
    output.covariance *= ratio;
    output.covariance_serial *= ratio;
    output.covariance_root *= std::sqrt(ratio);
    output.noise_variance *= ratio;
  }
}

double factor_of(const std::vector<Asked>& asked, UncertaintySource source) {
  for (const auto& one : asked)
    if (one.quantity->kind == DesignKind::line && one.quantity->subject == to_string(source))
      return one.value;
  return 1;
}

DesignLine& line_of(DesignOutput& output, UncertaintySource source) {
  for (auto& line : output.lines)
    if (line.source == source) return line;
  return output.lines.emplace_back(DesignLine{source, 0, 0});
}

Result<void> add_place(const BudgetPlace& place, const Snapshot& before, const Snapshot& after,
                       const std::vector<Asked>& asked, DesignStudy& study) {
  TargetRequest request = place.request;
  request.show_unreachable = true;  // a corner may lie beyond the travel: its budget is known
  for (const auto* snapshot : {&before, &after})
    if (const auto target = compute_target(*snapshot, request); target.refusal != Refusal::none)
      return tl::unexpected(refusal_error(*snapshot, target));
  for (std::size_t i = 0; i < before.outputs.size(); ++i) {
    DesignOutput output{place.name, before.outputs[i].channel, {}, 0, 0, {}, {}};
    const auto today = compute_budget(before, place.request, i),
               then = compute_budget(after, place.request, i);
    for (std::size_t k = 0; k < today.lines; ++k)
      line_of(output, today.line[k].source).u_before_nm = today.line[k].u_nm;
    for (std::size_t k = 0; k < then.lines; ++k)
      line_of(output, then.line[k].source).u_after_nm =
          then.line[k].u_nm * factor_of(asked, then.line[k].source);
    double after_nm2 = 0;
    for (const auto& line : output.lines) after_nm2 += line.u_after_nm * line.u_after_nm;
    output.u90_before_nm = kSigmaToU90 * today.u_nm;
    output.u90_after_nm = kSigmaToU90 * std::sqrt(after_nm2);
    study.outputs.push_back(std::move(output));
  }
  return {};
}

Result<void> add_uncompensated(const calibration::Model& model, const Dataset* rows,
                               const std::vector<DesignQuantity>& quantities,
                               const std::vector<Asked>& asked, DesignStudy& study) {
  std::map<std::string, double> today, then;
  for (const auto& one : quantities)
    if (one.kind == DesignKind::expansion) today[one.subject] = then[one.subject] = 1;
  bool changed = false;
  for (const auto& one : asked)
    if (one.quantity->kind == DesignKind::expansion)
      changed = true, then[one.quantity->subject] = one.value;
  if (today.empty()) return {};
  if (rows == nullptr) {
    if (changed)
      study.not_answered.push_back(
          "what another expansion would leave without terms of temperature: the rows that the "
          "model was fitted to are not on record");
    return {};
  }
  for (const auto& output : model.outputs) {
    DRIFTWISE_TRY(const double before_nm, thermal_rms_nm(output, *rows, today));
    DRIFTWISE_TRY(const double after_nm, thermal_rms_nm(output, *rows, then));
    for (auto& one : study.outputs) {
      if (one.channel.symbol != output.channel.symbol) continue;
      one.u90_uncompensated_before_nm = std::hypot(one.u90_before_nm, kSigmaToU90 * before_nm);
      one.u90_uncompensated_after_nm = std::hypot(one.u90_after_nm, kSigmaToU90 * after_nm);
    }
  }
  return {};
}

// Parts of the question that the budget does not answer.
void add_not_answered(const calibration::Model& model, const CellDescription& cell,
                      const std::vector<Asked>& asked, DesignStudy& study) {
  const auto any = [&](auto is) { return std::ranges::any_of(asked, is); };
  if (any([](const Asked& one) { return one.quantity->kind == DesignKind::expansion; }))
    study.not_answered.push_back(
        "how much of the line residual is thermal: it is left as it is with another expansion "
        "(residual.factor changes it)");
  if (any([](const Asked& one) {
        return one.quantity->key.starts_with("u_length") || one.quantity->key == "u_scale_nm";
      }))
    study.not_answered.push_back(
        "which terms a fit with another noise would choose: today's terms are kept");
  if (any([](const Asked& one) { return one.quantity->key.starts_with("offset_"); }))
    study.not_answered.push_back(
        "other tilts at another lever arm: those of the calibration act on it");
  // A value that no line follows, one by one.
  for (const auto& one : asked) {
    if (one.quantity->kind != DesignKind::instrument || one.value == one.quantity->value) continue;
    CellDescription alone = cell;
    one.quantity->set(alone, one.value);
    calibration::Model scattered = model;
    change_scatter(scattered, cell, alone);
    const auto before = model_snapshot(model, cell), after = model_snapshot(scattered, alone);
    if (!before || !after) continue;
    bool moves = false;
    for (const auto& place : budget_places(*before))
      for (std::size_t i = 0; i < before->outputs.size(); ++i)
        moves = moves || compute_budget(*before, place.request, i).u_nm !=
                             compute_budget(*after, place.request, i).u_nm;
    if (!moves)
      study.not_answered.push_back(
          one.quantity->name() +
          ": no line of this model's budget follows it (the calibration lacks what carries it into "
          "a target, or the fit absorbs it)");
  }
}

}  // namespace

const DesignLine* DesignOutput::largest(double DesignLine::*u) const {
  const auto found = std::ranges::max_element(lines, {}, u);
  return found == lines.end() ? nullptr : &*found;
}

Result<DesignStudy> study_design(const calibration::Model& model, const CellDescription& cell,
                                 std::span<const std::string> changes, const Dataset* rows) {
  const auto quantities = design_quantities(model, cell);
  std::vector<Asked> asked;
  for (const auto& text : changes) DRIFTWISE_RETURN_IF_ERROR(read_change(text, quantities, asked));
  DesignStudy study;
  CellDescription changed = cell;
  for (const auto& one : asked) {
    study.changes.push_back({one.quantity->name(), one.quantity->value, one.value});
    if (one.quantity->set) one.quantity->set(changed, one.value);
  }
  calibration::Model scattered = model;
  change_scatter(scattered, cell, changed);
  DRIFTWISE_TRY(const auto before, model_snapshot(model, cell));
  DRIFTWISE_TRY(const auto after, model_snapshot(scattered, changed));
  study.places = budget_places(before);
  for (const auto& place : study.places)
    DRIFTWISE_RETURN_IF_ERROR(add_place(place, before, after, asked, study));
  DRIFTWISE_RETURN_IF_ERROR(add_uncompensated(model, rows, quantities, asked, study));
  add_not_answered(model, cell, asked, study);
  study.quantities = quantities;
  return study;
}

}  // namespace driftwise::compensation
