#include "server/application/provenance/promotion_questions.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/provenance/configuration_book.h"
#include "server/calibration/report/accuracy.h"
#include "server/core/reasons.h"
#include "server/core/records/wanted_accuracy.h"
#include "server/effects/term_order.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::application {
namespace {

const ProbeDescription* probe_of(const CellDescription& cell, const std::string& symbol) {
  for (const auto& device : cell.devices)
    for (const auto& probe : device.probes())
      if (probe.channel.symbol == symbol) return &probe;
  return nullptr;
}

bool is_imported_geometry(const calibration::Model& model) {
  return model.geometry && model.geometry->covariance.size() == 0;
}

std::string joined(const std::vector<std::string>& questions) {
  std::string text;
  for (const auto& question : questions) text += (text.empty() ? "" : "; ") + question;
  return text;
}

}  // namespace

std::vector<std::string> symbols_used(const calibration::Model& model) {
  std::vector<std::string> symbols;
  const auto add = [&symbols](const std::string& symbol) {
    if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
  };
  for (const auto& output : model.outputs) {
    add(output.channel.symbol);
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term)) add(symbol);
  }
  if (!model.geometry) return symbols;
  // Of a delta or an axis the pose is an input, of an arm an output; either way it was measured.
  if (const auto made = kinematics::make_mechanism(model.geometry->robot)) {
    for (const auto& channel : (*made)->inputs()) add(channel.symbol);
    for (const auto& channel : (*made)->outputs()) add(channel.symbol);
  }
  return symbols;
}

std::vector<std::string> temperature_questions(const calibration::Model& model,
                                               const CellDescription& cell) {
  std::vector<std::string> questions;
  for (const auto& symbol : symbols_used(model)) {
    const auto* probe = probe_of(cell, symbol);
    if (!probe || probe->part == "robot") continue;
    questions.push_back(fmt::format(
        "{} is a thermometer of the {}{}, not of the robot: what goes with it is the instrument's "
        "error, and would be served as the robot's (fit with R, the robot's thermometers, instead "
        "of T)",
        symbol, probe->part, probe->place.empty() ? "" : fmt::format(" ({})", probe->place)));
  }
  return questions;
}

std::vector<std::string> accuracy_questions(const calibration::Model& model,
                                            const std::vector<RunMetadata>& of_its_runs) {
  if (is_imported_geometry(model)) return {};
  std::vector<WantedAccuracy> wanted;
  for (const auto& metadata : of_its_runs)
    for (const auto& item : metadata)
      if (states_wanted_accuracy(item.key))
        if (auto one = wanted_accuracy_from(item)) add_wanted(wanted, std::move(*one));
  std::vector<std::string> questions;
  if (wanted.empty()) return questions;
  if (model.lineage.rows_validation == 0)
    questions.push_back(
        "its campaign wants a stated accuracy and it was judged on no validation rows: nothing "
        "shows that it is reached");
  for (const auto& output : model.outputs) {
    // Its worst figure of rows held out; of the fit's own rows where none were.
    const auto judged =
        driftwise::heading_of(calibration::judged_accuracies(output, model.lineage)).front();
    const auto* limit = wanted_of(wanted, judged.output, judged.unit);
    if (limit == nullptr || judged.figures.a90 <= limit->a90) continue;
    questions.push_back(fmt::format(
        "its campaign wants an A90 of {:.4g} {}{} and it has {:.4g} {} ({})", limit->a90,
        judged.unit, limit->coordinate.empty() ? "" : " of " + limit->coordinate,
        judged.figures.a90, judged.unit, judged.output));
  }
  return questions;
}

std::vector<std::string> imported_geometry_questions(const calibration::Model& model) {
  if (!is_imported_geometry(model)) return {};
  return {
      "it is a robot file as it was imported: no data judged it, so that neither its domain nor "
      "its uncertainty is known (model import --data judges it)"};
}

std::vector<std::string> correction_questions(const std::vector<CorrectionRecord>& rests_on,
                                              const std::function<UtcTime(CellTime)>& utc) {
  std::vector<std::string> questions;
  // Accepted again after an undo: the data are those that it was fitted on.
  const auto stands_again = [&rests_on](const CorrectionRecord& ended) {
    return std::ranges::any_of(rests_on, [&ended](const CorrectionRecord& other) {
      return other.in_force() && other.diagnosis == ended.diagnosis && other.json == ended.json;
    });
  };
  for (const auto& correction : rests_on)
    if (!correction.in_force() && !stands_again(correction))
      questions.push_back(fmt::format(
          "it was fitted on data with correction {}{} in force, which {} took back at {}: the data "
          "are no longer those (fit it again)",
          correction.id.value,
          correction.diagnosis ? fmt::format(" of diagnosis {}", correction.diagnosis->value) : "",
          correction.ended_by, to_iso8601(utc(correction.ended))));
  return questions;
}

std::vector<std::string> configuration_questions(
    const calibration::Model& model, const std::vector<formats::ConfigurationChange>& since) {
  constexpr std::size_t kMostNamed = 4;
  const auto touched = touching(since, symbols_used(model));
  if (touched.empty()) return {};
  return {fmt::format("it was measured under another cell file: {}", list_of(touched, kMostNamed))};
}

Result<void> confirmation_of(const std::vector<std::string>& questions) {
  if (questions.empty()) return {};
  return fail(ErrorCode::failed_precondition, reasons::kNeedsConfirmation,
              fmt::format("before it serves a person has to confirm that it shall although {} "
                          "(--yes, or confirmed in the request)",
                          joined(questions)));
}

Result<void> reason_for(const std::vector<std::string>& questions) {
  if (questions.empty()) return {};
  return fail(ErrorCode::failed_precondition, reasons::kReasonRequired,
              fmt::format("{}: say why it serves all the same, for the record (--reason 'TEXT', or "
                          "reason in the request)",
                          joined(questions)));
}

}  // namespace driftwise::application
