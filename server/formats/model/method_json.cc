#include "server/formats/model/method_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/effects/term_order.h"
#include "server/formats/model/fit_json.h"

namespace driftwise::formats {
namespace {

using identification::Judgement;
using nlohmann::ordered_json;

ordered_json finite(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

void put_figure(ordered_json& json, const std::string& key, const std::optional<double>& value,
                const SummaryUnit& summary) {
  if (value) json[key + "_" + summary.unit] = finite(*value * summary.factor);
}

void put_held_out(ordered_json& json, const std::string& rows,
                  const std::optional<calibration::HeldOut>& held, const SummaryUnit& summary) {
  if (!held) return;
  put_figure(json, "u90_" + rows, held->figures.u90, summary);
  json["u90_" + rows + "_ci90_" + summary.unit] = {finite(held->u90_low * summary.factor),
                                                   finite(held->u90_high * summary.factor)};
  put_figure(json, "mean_" + rows, held->figures.mean, summary);
  put_figure(json, "a90_" + rows, held->figures.a90, summary);
  json["a90_" + rows + "_ci90_" + summary.unit] = {finite(held->low * summary.factor),
                                                   finite(held->high * summary.factor)};
}

ordered_json output_figures(const identification::OutputFigures& output) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  ordered_json json{{"unit", output.channel.unit}, {"parameters", output.parameters}};
  put_figure(json, "rms", output.rms, summary);
  put_figure(json, "u90_calibration", output.u90_calibration, summary);
  put_figure(json, "mean_calibration", output.mean_calibration, summary);
  put_figure(json, "a90_calibration", output.a90_calibration, summary);
  put_figure(json, "u90_validation", output.u90_validation, summary);
  put_figure(json, "mean_validation", output.mean_validation, summary);
  put_figure(json, "a90_validation", output.a90_validation, summary);
  put_held_out(json, "blocks", output.blocks, summary);
  put_held_out(json, "groups", output.groups, summary);
  put_figure(json, "pure_error", output.pure_error, summary);
  return json;
}

ordered_json position_figures(const identification::PositionFigures& position) {
  const SummaryUnit summary = summary_unit(position.unit);
  ordered_json json;
  put_figure(json, "rms", position.rms, summary);
  put_figure(json, "rms_validation", position.rms_validation, summary);
  put_figure(json, "rms_blocks", position.rms_blocks, summary);
  put_figure(json, "rms_groups", position.rms_groups, summary);
  put_figure(json, "pure_error", position.pure_error, summary);
  return json;
}

ordered_json kinematics_json(const identification::Identification& found) {
  ordered_json json{{"kind", found.mechanism->description().kind},
                    {"condition", finite(found.condition)},
                    {"evaluations", found.evaluations}};
  json["parameters"] = ordered_json::array();
  for (const auto& one : found.parameters) {
    ordered_json parameter{{"name", one.parameter.name},
                           {"nominal", one.parameter.nominal},
                           {"value", finite(one.value)},
                           {"free", one.free}};
    if (one.free) parameter["standard_error"] = finite(one.standard_error);
    if (!one.note.empty()) parameter["note"] = one.note;
    json["parameters"].push_back(std::move(parameter));
  }
  json["terms"] = ordered_json::object();
  for (std::size_t o = 0; o < found.mechanism->outputs().size() && !found.terms.empty(); ++o) {
    auto list = ordered_json::array();
    for (std::size_t j = 0; j < found.terms.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j), column = static_cast<Eigen::Index>(o);
      list.push_back({{"term", effects::notation(found.terms[j])},
                      {"coefficient", finite(found.coefficients(row, column))},
                      {"standard_error", finite(found.standard_errors(row, column))}});
    }
    json["terms"][found.mechanism->outputs()[o].symbol] = std::move(list);
  }
  return json;
}

}  // namespace

ordered_json method_json(const Judgement& judgement, const std::string& formula) {
  ordered_json json{{"schema", "driftwise.method.v1"},
                    {"method", identification::name_of(judgement.fitted.method)},
                    {"formula", formula},
                    {"rows",
                     {{"calibration", judgement.rows_calibration},
                      {"validation", judgement.rows_validation},
                      {"groups", judgement.groups}}},
                    {"parameters", judgement.fitted.parameters()},
                    {"fit_us", finite(judgement.fitted.fit_us)}};
  json["outputs"] = ordered_json::object();
  for (const auto& output : judgement.outputs)
    json["outputs"][output.channel.symbol] = output_figures(output);
  if (judgement.position) json["position"] = position_figures(*judgement.position);
  if (judgement.fitted.kinematics)
    json["kinematics"] = kinematics_json(*judgement.fitted.kinematics);
  if (judgement.fitted.linear) json["fit"] = fit_json(*judgement.fitted.linear);
  json["warnings"] = judgement.warnings;
  return json;
}

ordered_json comparison_json(const std::vector<Judgement>& judgements, const std::string& formula) {
  ordered_json json{{"schema", "driftwise.comparison.v1"}, {"formula", formula}};
  json["methods"] = ordered_json::array();
  for (const auto& judgement : judgements)
    json["methods"].push_back(method_json(judgement, formula));
  return json;
}

}  // namespace driftwise::formats
