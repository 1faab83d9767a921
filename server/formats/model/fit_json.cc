#include "server/formats/model/fit_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/calibration/report/accuracy.h"
#include "server/effects/term_order.h"
#include "server/formats/model/coefficient_unit.h"

namespace driftwise::formats {
namespace {

using nlohmann::ordered_json;

// JSON has no infinity and no NaN: null says "no number".
ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

void put(ordered_json& json, const std::string& key, const std::optional<double>& value,
         double factor = 1) {
  if (value) json[key] = number(*value * factor);
}

ordered_json term_json(const calibration::TermReport& report, const SummaryUnit& summary,
                       const std::string& unit) {
  ordered_json json;
  json["term"] = effects::notation(report.term);
  json["in"] = report.in;
  if (!unit.empty()) json["unit"] = unit;
  json["coefficient"] = number(report.coefficient);
  json["standard_error"] = number(report.standard_error);
  if (report.in) json["standard_error_serial"] = number(report.standard_error_serial);
  json["t"] = number(report.t);
  json["p"] = number(report.p);
  if (report.in && !report.term.is_constant()) {
    json["vif"] = number(report.vif);
    json["contribution_rms_" + summary.unit] = number(report.contribution_rms * summary.factor);
    json["contribution_max_" + summary.unit] = number(report.contribution_max * summary.factor);
  }
  if (!report.replaceable_by.empty()) json["replaceable_by"] = report.replaceable_by;
  if (!report.note.empty()) json["note"] = report.note;
  return json;
}

ordered_json covariance_json(const Eigen::MatrixXd& covariance) {
  auto rows = ordered_json::array();
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    auto row = ordered_json::array();
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) row.push_back(number(covariance(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

// "a90_nm": the figures of one heading, with what it was before on the same output and rows.
ordered_json judged_json(const JudgedAccuracy& one) {
  const auto figures = [&one](const ErrorFigures& of) {
    return ordered_json{{"a90_" + one.unit, number(of.a90)},
                        {"mean_" + one.unit, number(of.mean)},
                        {"u90_" + one.unit, number(of.u90)}};
  };
  ordered_json json{{"output", one.output}, {"rows", to_string(one.rows)}};
  json.update(figures(one.figures));
  if (one.before) json["before"] = figures(*one.before);
  return json;
}

ordered_json output_summary(const calibration::OutputModel& output,
                            const calibration::Model& model) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  const auto key = [&summary](const std::string& name) { return name + "_" + summary.unit; };
  const auto& accuracy = output.accuracy;
  ordered_json json;
  json["unit"] = output.channel.unit;
  json["dof"] = output.dof;
  json[key("rmse")] = number(accuracy.rmse * summary.factor);
  json[key("u90_calibration")] = number(accuracy.u90_calibration * summary.factor);
  json[key("mean_calibration")] = number(accuracy.mean_calibration * summary.factor);
  json[key("a90_calibration")] = number(accuracy.a90_calibration * summary.factor);
  put(json, key("u90_validation"), accuracy.u90_validation, summary.factor);
  put(json, key("mean_validation"), accuracy.mean_validation, summary.factor);
  put(json, key("a90_validation"), accuracy.a90_validation, summary.factor);
  for (const auto& set : accuracy.validation_sets)
    json["validation_sets"][set.name] = {{"rows", set.figures.rows},
                                         {key("a90"), number(set.figures.a90 * summary.factor)},
                                         {key("mean"), number(set.figures.mean * summary.factor)},
                                         {key("u90"), number(set.figures.u90 * summary.factor)}};
  put(json, key("u90_blocks"), accuracy.u90_blocks, summary.factor);
  put(json, key("mean_blocks"), accuracy.mean_blocks, summary.factor);
  put(json, key("a90_blocks"), accuracy.a90_blocks, summary.factor);
  const auto interval = [&](const char* name, const auto& low, const auto& high) {
    if (low && high)
      json[key(name)] = {number(*low * summary.factor), number(*high * summary.factor)};
  };
  interval("u90_blocks_ci90", accuracy.u90_blocks_low, accuracy.u90_blocks_high);
  interval("a90_blocks_ci90", accuracy.a90_blocks_low, accuracy.a90_blocks_high);
  json["lag1_autocorrelation"] = number(accuracy.lag1_autocorrelation);
  json["effective_rows"] = number(accuracy.effective_rows);
  json["slow_noise"] = {{"share", number(accuracy.slow_share)},
                        {"rows", number(accuracy.slow_rows)}};
  put(json, key("pure_error"), accuracy.pure_error, summary.factor);
  put(json, "lack_of_fit_f", accuracy.lack_of_fit_f);
  put(json, "lack_of_fit_p", accuracy.lack_of_fit_p);
  json["condition_index"] = number(accuracy.condition_index);
  put(json, "model_f", accuracy.model_f);
  put(json, "model_p", accuracy.model_p);
  put(json, "aic", accuracy.aic);
  put(json, "bic", accuracy.bic);
  json["terms"] = ordered_json::array();
  for (const auto& report : output.report)
    json["terms"].push_back(
        term_json(report, summary, report.in ? coefficient_unit(output, report.term, model) : ""));
  json["covariance"] = covariance_json(output.covariance);
  json["history"] = ordered_json::array();
  for (const auto& step : output.history) {
    json["history"].push_back({{"step", step.step},
                               {"action", step.action},
                               {"term", effects::notation(step.term)},
                               {"p", number(step.p)},
                               {key("rmse"), number(step.rmse * summary.factor)},
                               {"dof", step.dof}});
    put(json["history"].back(), "criterion_value", step.value);
  }
  if (output.starts.empty()) return json;
  json["starts"] = ordered_json::array();
  for (const auto& start : output.starts) {
    json["starts"].push_back({{"start", start.name},
                              {"won", start.won},
                              {"began_with", start.began_with},
                              {"ended_with", start.ended_with},
                              {key("rmse"), number(start.rmse * summary.factor)}});
    put(json["starts"].back(), "criterion_value", start.value);
  }
  return json;
}

}  // namespace

ordered_json heading_json(const std::vector<JudgedAccuracy>& heading) {
  auto json = ordered_json::array();
  for (const auto& one : heading) json.push_back(judged_json(one));
  return json;
}

ordered_json fit_json(const calibration::Model& model) {
  ordered_json json;
  json["schema"] = "driftwise.fit.v1";
  json["formula"] = model.formula;
  json["select"] = model.select;
  json["criterion"] = model.criterion;
  json["hierarchy"] = model.hierarchy;
  json["starts"] = model.starts;
  if (model.starts > 1) json["seed"] = model.seed;
  json["p_enter"] = model.p_enter;
  json["p_remove"] = model.p_remove;
  json["rows"] = {{"calibration", model.lineage.rows_calibration},
                  {"validation", model.lineage.rows_validation},
                  {"dropped", model.lineage.rows_dropped},
                  {"excluded", model.lineage.rows_excluded}};
  json["accuracy"] = heading_json(calibration::heading_of(model));
  json["outputs"] = ordered_json::object();
  for (const auto& output : model.outputs)
    json["outputs"][output.channel.symbol] = output_summary(output, model);
  json["domain"] = ordered_json::object();
  for (const auto& range : model.domain)
    json["domain"][range.channel.name()] = {range.min, range.max};
  json["fit_us"] = number(model.fit_us);
  for (const auto& zero : model.datum_zeros) {
    ordered_json one = {{"datum", zero.ordinal}, {"pose", ordered_json::object()}};
    for (const auto& [channel, value] : zero.pose) one["pose"][channel] = number(value);
    if (!zero.why_not.empty()) one["why_not"] = zero.why_not;
    json["datum_zeros"].push_back(std::move(one));
  }
  json["warnings"] = model.warnings;
  return json;
}

}  // namespace driftwise::formats
