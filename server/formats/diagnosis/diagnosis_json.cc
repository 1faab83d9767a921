#include "server/formats/diagnosis/diagnosis_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/core/text/quantity_text.h"
#include "server/diagnosis/report/heading.h"
#include "server/diagnosis/report/taken_by_time.h"
#include "server/effects/term_order.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/model/fit_json.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json interval_json(const diagnosis::Interval& interval) {
  return Json::array({interval.low, interval.high});
}

Json parameters_json(const std::vector<diagnosis::FoundParameter>& parameters) {
  Json list = Json::object();
  for (const auto& parameter : parameters) {
    Json one{{"value", parameter.value}};
    if (parameter.ci90) one["ci90"] = interval_json(*parameter.ci90);
    if (!parameter.curve.empty()) {
      one["curve"] = Json::array();
      for (const auto& point : parameter.curve)
        one["curve"].push_back({{"value", point.value}, {"below_2lnl", point.below_2lnl}});
    }
    if (!parameter.aliases.empty()) one["aliases"] = parameter.aliases;
    list[parameter.name] = std::move(one);
  }
  return list;
}

Json finding_json(const diagnosis::Finding& finding,
                  const std::vector<correction::RowOrigin>& origins) {
  Json one;
  one["cause"] = finding.cause;
  one["applies_to"] = std::string(effects::to_string(finding.applies_to));
  one["where"] = finding.where;
  one["subject"] = finding.subject;
  one["outputs"] = Json::array();
  for (const auto& output : finding.outputs)
    if (output.shown) one["outputs"].push_back(output.output);
  one["terms"] = Json::array();
  for (const auto& term : finding.terms) one["terms"].push_back(effects::notation(term));
  one["parameters"] = parameters_json(finding.parameters);
  Json gain = Json::object();
  for (const auto& output : finding.outputs) {
    one["amplitude_" + output.unit][output.output] = output.amplitude;
    if (output.correction_u90)
      one["correction_u90_" + output.unit][output.output] = *output.correction_u90;
    if (!output.u90_before || !output.u90_after) continue;
    Json judged{{"u90_before_" + output.unit, number_or_null(*output.u90_before)},
                {"u90_after_" + output.unit, number_or_null(*output.u90_after)}};
    if (output.u90_after_ci90)
      judged["ci90_" + output.unit] = interval_json(*output.u90_after_ci90);
    const auto put = [&](const char* key, const std::optional<double>& value) {
      if (value) judged[key + output.unit] = number_or_null(*value);
    };
    put("mean_before_", output.mean_before);
    put("mean_after_", output.mean_after);
    put("a90_before_", output.a90_before);
    put("a90_after_", output.a90_after);
    if (output.a90_after_ci90)
      judged["a90_ci90_" + output.unit] = interval_json(*output.a90_after_ci90);
    gain[output.output] = std::move(judged);
  }
  if (!finding.rows.empty()) {
    one["rows"] = Json::array();
    for (const std::size_t row : finding.rows) {
      if (row < origins.size()) one["row_runs"].push_back(origins[row].run.value);
      one["rows"].push_back(row < origins.size() ? origins[row].row + 1
                                                 : static_cast<std::int64_t>(row) + 1);
    }
  }
  one["p_adjusted"] = finding.p_adjusted;
  one["log_likelihood_ratio"] = finding.log_likelihood_ratio;
  one["indistinguishable_from"] = finding.indistinguishable_from;
  one["gain"] = std::move(gain);
  one["sentence"] = finding.sentence;
  return one;
}

// Of one simulation: the baseline, or the extended one.
struct JudgedSimulation {
  double u90, mean, a90;  // calibration rows
  const std::optional<double>&u90_held_out, &mean_held_out, &a90_held_out;
};

Json output_json(const std::string& unit, const JudgedSimulation& judged) {
  Json one{{"u90_calibration_" + unit, number_or_null(judged.u90)},
           {"mean_calibration_" + unit, number_or_null(judged.mean)},
           {"a90_calibration_" + unit, number_or_null(judged.a90)}};
  if (judged.u90_held_out) one["u90_validation_" + unit] = number_or_null(*judged.u90_held_out);
  if (judged.mean_held_out) one["mean_validation_" + unit] = number_or_null(*judged.mean_held_out);
  if (judged.a90_held_out) one["a90_validation_" + unit] = number_or_null(*judged.a90_held_out);
  return one;
}

Json discrepancy_json(const diagnosis::OutputSummary& output) {
  Json one{{"u90_" + output.unit, output.u90},
           {"mean_" + output.unit, output.mean},
           {"a90_" + output.unit, output.a90}};
  if (output.noise_floor_u90) one["noise_floor_" + output.unit] = *output.noise_floor_u90;
  one["explained_by"] = Json::array();
  for (const auto& share : output.explained_by)
    one["explained_by"].push_back({{"variable", share.variable}, {"marginal_share", share.share}});
  one["noise"] = {{"white_sd_" + output.unit, output.noise_white_sd},
                  {"slow_sd_" + output.unit, output.noise_slow_sd},
                  {"tau_s", output.noise_tau_s}};
  return one;
}

Json experiment_json(const std::optional<diagnosis::SeparatingExperiment>& experiment) {
  if (!experiment) return nullptr;
  Json one{{"why", experiment->why}};
  if (experiment->predicted_power) one["predicted_power"] = *experiment->predicted_power;
  if (!experiment->trajectory_csv.empty()) {
    one["trajectory_csv"] = experiment->trajectory_csv;
    one["estimated_s"] = experiment->estimated_s;
  }
  return one;
}

}  // namespace

Json diagnosis_json(const diagnosis::Diagnosis& d,
                    const std::vector<correction::RowOrigin>& origins) {
  Json json;
  json["schema"] = "driftwise.diagnosis.v1";
  if (const auto robot = robot_of_formula(d.baseline_formula); !robot.empty())
    json["robot"] = robot;
  json["verdict"] = std::string(diagnosis::to_string(d.verdict));
  json["accuracy"] = heading_json(diagnosis::heading_of(d));
  json["rows"] = {{"calibration", d.rows_calibration}, {"held_out", d.rows_held_out}};
  json["baseline"] = {{"formula", d.baseline_formula}, {"outputs", Json::object()}};
  json["discrepancy"] = Json::object();
  Json extended{{"formula", d.extended_formula}, {"outputs", Json::object()}};
  for (const auto& output : d.outputs) {
    json["baseline"]["outputs"][output.output] =
        output_json(output.unit, {output.u90_calibration_before, output.mean_calibration_before,
                                  output.a90_calibration_before, output.u90_validation_before,
                                  output.mean_validation_before, output.a90_validation_before});
    json["discrepancy"][output.output] = discrepancy_json(output);
    extended["outputs"][output.output] =
        output_json(output.unit, {output.u90_calibration_after, output.mean_calibration_after,
                                  output.a90_calibration_after, output.u90_validation_after,
                                  output.mean_validation_after, output.a90_validation_after});
  }
  json["findings"] = Json::array();
  for (const auto& finding : d.findings) json["findings"].push_back(finding_json(finding, origins));
  json["left_over"] = Json::array();
  for (const auto& rest : d.left_over)
    json["left_over"].push_back({{"goes_with", rest.goes_with}, {"p_adjusted", rest.p_adjusted}});
  json["not_testable"] = Json::array();
  for (const auto& one : d.not_testable)
    json["not_testable"].push_back({{"cause", one.cause}, {"why", one.why}});
  json["extended"] = std::move(extended);
  json["separating_experiment"] = experiment_json(d.separating_experiment);
  json["nulls"] = d.nulls;
  json["warnings"] = d.warnings;
  return json;
}

std::string diagnosis_page(const diagnosis::Diagnosis& d) {
  const auto robot = robot_of_formula(d.baseline_formula);
  std::string page =
      "Diagnosis of " + (robot.empty() ? "" : "robot " + robot + ": ") + d.baseline_formula + "\n";
  page += std::to_string(d.rows_calibration) + " rows searched, " +
          std::to_string(d.rows_held_out) + " held out\n\n";
  page += "verdict: " + std::string(diagnosis::to_string(d.verdict)) + "\n";
  for (const auto& rest : d.left_over)
    page += "  structure remains that no cause of the catalogue explains; it goes with " +
            rest.goes_with + "\n";
  if (!diagnosis::taken_by_time(d).empty())
    page += "  slow noise has most of what is left: a drift may be in it, see the notes\n";
  for (const auto& one : diagnosis::heading_of(d))
    page += "accuracy (A90), before -> after: " + accuracy_text(one) + "\n";
  const auto judged = diagnosis::judged_accuracies(d);
  if (judged.size() > 1) page += "\nA90, before -> after\n";
  for (const auto& one : judged)
    if (judged.size() > 1) page += "  " + accuracy_text(one) + "\n";
  page += d.findings.empty() ? "\nno cause is supported by these data\n" : "\nfindings\n";
  int number = 0;
  for (const auto& finding : d.findings) {
    page += "  " + std::to_string(++number) + ". " + finding.cause +
            (finding.subject.empty() ? "" : " " + finding.subject) + ": " + finding.sentence + "\n";
  }
  if (!d.not_testable.empty()) page += "\nnot testable with these data\n";
  for (const auto& one : d.not_testable) page += "  " + one.cause + ": " + one.why + "\n";
  if (d.separating_experiment) {
    page += "\nseparating measurement: " + d.separating_experiment->why;
    if (d.separating_experiment->predicted_power)
      page += " (power " + digits_text(*d.separating_experiment->predicted_power, 2) + ")";
    page += "\n";
  }
  for (const auto& warning : d.warnings) page += "\nnote: " + warning + "\n";
  return page;
}

}  // namespace driftwise::formats
