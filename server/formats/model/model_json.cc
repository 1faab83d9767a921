#include "server/formats/model/model_json.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/model/geometry_json.h"
#include "server/formats/model/model_json_uncertainty.h"
#include "server/formats/text/json_place.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using calibration::Accuracy;
using calibration::Lineage;
using calibration::Model;
using calibration::OutputModel;
using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "driftwise.model.v1";

// A member that is added to a model and forgotten here would be lost on disk: then these do not
// compile.
[[maybe_unused]] void every_member_is_written(const Model& model, const OutputModel& output,
                                              const Accuracy& accuracy,
                                              const calibration::TermReport& report,
                                              const calibration::SelectionStep& step,
                                              const Lineage& lineage) {
  [[maybe_unused]] const auto& [m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15] =
      model;
  [[maybe_unused]] const auto& [o1, o2, o3, o4, o5, o6, o7, o8, o9, o10, o11, o12, o13, o14] =
      output;
  [[maybe_unused]] const auto& [a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14, a15,
                                a16, a17, a18, a19, a20, a21, a22, a23, a24, a25, a26, a27, a28] =
      accuracy;
  [[maybe_unused]] const auto& [r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12] = report;
  [[maybe_unused]] const auto& [s1, s2, s3, s4, s5, s6, s7] = step;
  [[maybe_unused]] const auto& [l1, l2, l3, l4, l5, l6, l7, l8, l9, l10] = lineage;
}

// --- terms ---

Json factors_json(const effects::Term& term) {
  Json out = Json::array();
  for (const auto& factor : term.factors) {
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      out.push_back({{"symbol", power->symbol}, {"exponent", power->exponent}});
      continue;
    }
    const auto& call = std::get<effects::Call>(factor);
    Json parameters = Json::array();
    for (const auto& parameter : call.parameters)
      parameters.push_back({{"value", parameter.value}, {"unit", parameter.unit}});
    out.push_back({{"effect", call.effect},
                   {"symbols", call.symbols},
                   {"parameters", std::move(parameters)}});
  }
  return out;
}

Json term_json(const effects::Term& term) {
  return {{"term", effects::notation(term)}, {"factors", factors_json(term)}};
}

effects::Term read_term(const JsonPlace& from) {
  effects::Term term;
  const auto factors = from["factors"];
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto factor = factors[i];
    if (!factor.has("effect")) {
      term.factors.push_back(effects::Power{factor["symbol"].text(),
                                            static_cast<int>(factor["exponent"].integer(1, 64))});
      continue;
    }
    effects::Call call{factor["effect"].text(), {}, {}};
    const auto symbols = factor["symbols"], parameters = factor["parameters"];
    for (std::size_t k = 0; k < symbols.size(); ++k) call.symbols.push_back(symbols[k].text());
    for (std::size_t k = 0; k < parameters.size(); ++k)
      call.parameters.push_back({parameters[k]["value"].finite(), parameters[k]["unit"].text()});
    term.factors.push_back(std::move(call));
  }
  return term;
}

// --- accuracy ---

// The optional figures by name: written when they are there.
template <class A, class Visit>
void each_optional(A& accuracy, Visit visit) {
  visit("u90_validation", accuracy.u90_validation);
  visit("u90_blocks", accuracy.u90_blocks);
  visit("u90_blocks_low", accuracy.u90_blocks_low);
  visit("u90_blocks_high", accuracy.u90_blocks_high);
  visit("mean_validation", accuracy.mean_validation);
  visit("a90_validation", accuracy.a90_validation);
  visit("mean_blocks", accuracy.mean_blocks);
  visit("a90_blocks", accuracy.a90_blocks);
  visit("a90_blocks_low", accuracy.a90_blocks_low);
  visit("a90_blocks_high", accuracy.a90_blocks_high);
  visit("block_count", accuracy.block_count);
  visit("pure_error", accuracy.pure_error);
  visit("lack_of_fit_f", accuracy.lack_of_fit_f);
  visit("lack_of_fit_p", accuracy.lack_of_fit_p);
  visit("model_f", accuracy.model_f);
  visit("model_p", accuracy.model_p);
  visit("aic", accuracy.aic);
  visit("bic", accuracy.bic);
}
template <class A, class Visit>
void each_figure(A& accuracy, Visit visit) {
  visit("rmse", accuracy.rmse);
  visit("u90_calibration", accuracy.u90_calibration);
  visit("lag1_autocorrelation", accuracy.lag1_autocorrelation);
  visit("effective_rows", accuracy.effective_rows);
  visit("condition_index", accuracy.condition_index);
}

// Models stored by 0.1 lack these.
template <class A, class Visit>
void each_later_figure(A& accuracy, Visit visit) {
  visit("slow_share", accuracy.slow_share);
  visit("slow_rows", accuracy.slow_rows);
  visit("mean_calibration", accuracy.mean_calibration);
  visit("a90_calibration", accuracy.a90_calibration);
}

Json accuracy_json(const Accuracy& accuracy) {
  Json out = Json::object();
  each_later_figure(accuracy,
                    [&](const char* key, double value) { out[key] = json_number(value); });
  each_figure(accuracy, [&](const char* key, double value) { out[key] = json_number(value); });
  each_optional(accuracy, [&](const char* key, const std::optional<double>& value) {
    if (value) out[key] = json_number(*value);
  });
  for (const auto& set : accuracy.validation_sets)
    out["validation_sets"].push_back({{"name", set.name},
                                      {"rows", set.figures.rows},
                                      {"mean", json_number(set.figures.mean)},
                                      {"u90", json_number(set.figures.u90)},
                                      {"a90", json_number(set.figures.a90)}});
  return out;
}

Accuracy read_accuracy(const JsonPlace& from) {
  Accuracy accuracy;
  each_figure(accuracy, [&](const char* key, double& value) { value = from[key].number(); });
  // A fit with a constant has residuals of mean 0: what a model without A90 is read with.
  accuracy.a90_calibration = accuracy.u90_calibration;
  each_later_figure(accuracy, [&](const char* key, double& value) {
    if (from.has(key)) value = from[key].number();
  });
  each_optional(accuracy, [&](const char* key, std::optional<double>& value) {
    if (from.has(key)) value = from[key].number();
  });
  if (!from.has("validation_sets")) return accuracy;
  const auto sets = from["validation_sets"];
  for (std::size_t i = 0; i < sets.size(); ++i)
    accuracy.validation_sets.push_back({sets[i]["name"].text(),
                                        {.rows = sets[i]["rows"].integer(0),
                                         .mean = sets[i]["mean"].number(),
                                         .u90 = sets[i]["u90"].number(),
                                         .a90 = sets[i]["a90"].number()}});
  return accuracy;
}

// --- report and history ---

template <class R, class Visit>
void each_statistic(R& row, Visit visit) {
  visit("coefficient", row.coefficient);
  visit("standard_error", row.standard_error);
  visit("t", row.t);
  visit("p", row.p);
  visit("vif", row.vif);
  visit("contribution_rms", row.contribution_rms);
  visit("contribution_max", row.contribution_max);
}

Json report_json(const calibration::TermReport& row) {
  Json out = term_json(row.term);
  out["in"] = row.in;
  out["note"] = row.note;
  if (!row.replaceable_by.empty()) out["replaceable_by"] = row.replaceable_by;
  out["standard_error_serial"] = json_number(row.standard_error_serial);
  each_statistic(row, [&](const char* key, double value) { out[key] = json_number(value); });
  return out;
}

calibration::TermReport read_report(const JsonPlace& from) {
  calibration::TermReport row;
  row.term = read_term(from);
  row.in = from["in"].truth();
  row.note = from["note"].text();
  if (from.has("replaceable_by"))
    for (std::size_t i = 0; i < from["replaceable_by"].size(); ++i)
      row.replaceable_by.push_back(from["replaceable_by"][i].text());
  if (from.has("standard_error_serial"))
    row.standard_error_serial = from["standard_error_serial"].number();
  each_statistic(row, [&](const char* key, double& value) { value = from[key].number(); });
  return row;
}

Json step_json(const calibration::SelectionStep& step) {
  Json out = term_json(step.term);
  out.update({{"step", step.step},
              {"action", step.action},
              {"p", json_number(step.p)},
              {"rmse", json_number(step.rmse)},
              {"dof", step.dof}});
  if (step.value) out["value"] = json_number(*step.value);
  return out;
}

Json start_json(const calibration::StartOutcome& start) {
  Json out = {{"name", start.name},
              {"began_with", start.began_with},
              {"ended_with", start.ended_with},
              {"rmse", json_number(start.rmse)},
              {"won", start.won}};
  if (start.value) out["value"] = json_number(*start.value);
  return out;
}

calibration::StartOutcome read_start(const JsonPlace& from) {
  calibration::StartOutcome start;
  start.name = from["name"].text();
  start.began_with = static_cast<int>(from["began_with"].integer(0, INT32_MAX));
  start.ended_with = static_cast<int>(from["ended_with"].integer(0, INT32_MAX));
  start.rmse = from["rmse"].number();
  start.won = from["won"].truth();
  if (from.has("value")) start.value = from["value"].number();
  return start;
}

calibration::SelectionStep read_step(const JsonPlace& from) {
  return {.step = static_cast<int>(from["step"].integer(0, INT32_MAX)),
          .action = from["action"].text(),
          .term = read_term(from),
          .p = from["p"].number(),
          .rmse = from["rmse"].number(),
          .dof = static_cast<int>(from["dof"].integer(INT32_MIN, INT32_MAX)),
          .value = from.has("value") ? std::optional(from["value"].number()) : std::nullopt};
}

// --- outputs ---

Json output_json(const OutputModel& output) {
  Json terms = Json::array(), report = Json::array(), history = Json::array();
  for (std::size_t k = 0; k < output.terms.size(); ++k) {
    Json term = term_json(output.terms[k]);
    term["coefficient"] = output.coefficients[static_cast<Eigen::Index>(k)];
    terms.push_back(std::move(term));
  }
  for (const auto& row : output.report) report.push_back(report_json(row));
  for (const auto& step : output.history) history.push_back(step_json(step));
  Json starts = Json::array();
  for (const auto& start : output.starts) starts.push_back(start_json(start));
  Json out = {{"channel", output.channel.name()},
              {"dof", output.dof},
              {"accuracy", accuracy_json(output.accuracy)},
              {"terms", std::move(terms)},
              {"covariance", matrix_json(output.covariance)},
              {"report", std::move(report)},
              {"history", std::move(history)},
              {"starts", std::move(starts)}};
  write_uncertainty(output, out);
  if (!output.held_out.empty()) {
    Json& held_out = out["held_out"] = Json::array();
    for (const double error : output.held_out) held_out.push_back(json_number(error));
  }
  return out;
}

OutputModel read_output(const JsonPlace& from) {
  OutputModel output;
  output.channel = from["channel"].channel();
  output.dof = static_cast<int>(from["dof"].integer(INT32_MIN, INT32_MAX));
  output.accuracy = read_accuracy(from["accuracy"]);
  const auto terms = from["terms"], report = from["report"], history = from["history"];
  const std::size_t count = terms.size();
  output.covariance = read_matrix(from["covariance"], count);
  read_uncertainty(from, count, output);
  output.coefficients.resize(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    output.terms.push_back(read_term(terms[i]));
    output.coefficients[static_cast<Eigen::Index>(i)] = terms[i]["coefficient"].finite();
  }
  for (std::size_t i = 0; i < report.size(); ++i) output.report.push_back(read_report(report[i]));
  for (std::size_t i = 0; i < history.size(); ++i) output.history.push_back(read_step(history[i]));
  if (from.has("starts"))  // models stored by 0.1 have none
    for (std::size_t i = 0; i < from["starts"].size(); ++i)
      output.starts.push_back(read_start(from["starts"][i]));
  if (from.has("held_out")) {
    const auto held_out = from["held_out"];
    for (std::size_t i = 0; i < held_out.size(); ++i)
      output.held_out.push_back(held_out[i].number());
  }
  return output;
}

// --- the whole ---

Json measured_by_json(const std::vector<MeasuredBy>& coordinates) {
  Json out = Json::array();
  for (const auto& coordinate : coordinates) {
    Json& one = out.emplace_back(Json{{"symbol", coordinate.symbol}});
    for (const auto& part : coordinate.parts)
      one["parts"].push_back({{"devices", part.devices}, {"rows", part.rows}});
  }
  return out;
}

std::vector<MeasuredBy> read_measured_by(const JsonPlace& from) {
  std::vector<MeasuredBy> out;
  for (std::size_t i = 0; i < from.size(); ++i) {
    auto& coordinate = out.emplace_back(MeasuredBy{from[i]["symbol"].text(), {}});
    const auto parts = from[i]["parts"];
    for (std::size_t p = 0; p < parts.size(); ++p) {
      auto& part = coordinate.parts.emplace_back();
      const auto devices = parts[p]["devices"];
      for (std::size_t d = 0; d < devices.size(); ++d) part.devices.push_back(devices[d].text());
      part.rows = parts[p]["rows"].finite();
    }
  }
  return out;
}

Json lineage_json(const Lineage& lineage) {
  Json runs = Json::array();
  for (const auto run : lineage.runs) runs.push_back(run.value);
  Json out = {{"runs", std::move(runs)},
              {"source", lineage.source},
              {"dataset_hash", lineage.dataset_hash},
              {"rows_calibration", lineage.rows_calibration},
              {"rows_validation", lineage.rows_validation},
              {"rows_dropped", lineage.rows_dropped},
              {"rows_excluded", lineage.rows_excluded},
              {"exclusions_hash", lineage.exclusions_hash}};
  if (lineage.parent) out["parent"] = lineage.parent->value;
  if (!lineage.measured_by.empty()) out["measured_by"] = measured_by_json(lineage.measured_by);
  return out;
}

Lineage read_lineage(const JsonPlace& from) {
  Lineage lineage;
  const auto runs = from["runs"];
  for (std::size_t i = 0; i < runs.size(); ++i) lineage.runs.push_back({runs[i].integer()});
  lineage.source = from["source"].text();
  lineage.dataset_hash = from["dataset_hash"].text();
  lineage.rows_calibration = from["rows_calibration"].integer(0);
  lineage.rows_validation = from["rows_validation"].integer(0);
  lineage.rows_dropped = from["rows_dropped"].integer(0);
  if (from.has("rows_excluded")) {  // models of before 0.2 had none
    lineage.rows_excluded = from["rows_excluded"].integer(0);
    lineage.exclusions_hash = from["exclusions_hash"].text();
  }
  if (from.has("parent")) lineage.parent = ModelId{from["parent"].integer()};
  if (from.has("measured_by")) lineage.measured_by = read_measured_by(from["measured_by"]);
  return lineage;
}

Json datum_zeros_json(const std::vector<calibration::DatumZero>& zeros) {
  Json out = Json::array();
  for (const auto& zero : zeros) {
    Json& one = out.emplace_back(Json{{"datum", zero.ordinal}});
    if (!zero.why_not.empty()) one["why_not"] = zero.why_not;
    Json pose = Json::array();
    for (const auto& [channel, value] : zero.pose)
      pose.push_back({{"channel", channel}, {"value", value}});
    one["pose"] = std::move(pose);
  }
  return out;
}

std::vector<calibration::DatumZero> read_datum_zeros(const JsonPlace& from) {
  std::vector<calibration::DatumZero> zeros;
  for (std::size_t i = 0; i < from.size(); ++i) {
    auto& zero = zeros.emplace_back();
    zero.ordinal = static_cast<int>(from[i]["datum"].integer(2, INT32_MAX));
    if (from[i].has("why_not")) zero.why_not = from[i]["why_not"].text();
    const auto pose = from[i]["pose"];
    for (std::size_t k = 0; k < pose.size(); ++k)
      zero.pose.push_back({pose[k]["channel"].text(), pose[k]["value"].finite()});
  }
  return zeros;
}

Model read_whole(const JsonPlace& from) {
  if (from["schema"].text() != kSchema) from["schema"].refuse(std::string("'") + kSchema + "'");
  Model model;
  model.formula = from["formula"].text();
  model.select = from["select"].text();
  if (from.has("criterion")) model.criterion = from["criterion"].text();
  if (from.has("hierarchy")) model.hierarchy = from["hierarchy"].truth();
  if (from.has("starts")) model.starts = static_cast<int>(from["starts"].integer(1, INT32_MAX));
  if (from.has("seed")) model.seed = from["seed"].integer(0);
  model.p_enter = from["p_enter"].finite();
  model.p_remove = from["p_remove"].finite();
  model.lineage = read_lineage(from["lineage"]);
  const auto outputs = from["outputs"], domain = from["domain"], warnings = from["warnings"];
  for (std::size_t i = 0; i < outputs.size(); ++i) model.outputs.push_back(read_output(outputs[i]));
  for (std::size_t i = 0; i < domain.size(); ++i)
    model.domain.push_back(
        {domain[i]["channel"].channel(), domain[i]["min"].finite(), domain[i]["max"].finite()});
  for (std::size_t i = 0; i < warnings.size(); ++i) model.warnings.push_back(warnings[i].text());
  if (from.has("datum_zeros")) model.datum_zeros = read_datum_zeros(from["datum_zeros"]);
  if (from.has("geometry")) model.geometry = read_geometry(from["geometry"]);
  model.fit_us = from["fit_us"].finite();
  return model;
}

}  // namespace

std::string write_model_json(const Model& model, int indent) {
  Json outputs = Json::array(), domain = Json::array();
  for (const auto& output : model.outputs) outputs.push_back(output_json(output));
  for (const auto& range : model.domain)
    domain.push_back({{"channel", range.channel.name()}, {"min", range.min}, {"max", range.max}});
  Json out = {{"schema", kSchema},
              {"formula", model.formula},
              {"select", model.select},
              {"criterion", model.criterion},
              {"hierarchy", model.hierarchy},
              {"starts", model.starts},
              {"seed", model.seed},
              {"p_enter", model.p_enter},
              {"p_remove", model.p_remove},
              {"outputs", std::move(outputs)},
              {"domain", std::move(domain)},
              {"lineage", lineage_json(model.lineage)},
              {"warnings", model.warnings},
              {"fit_us", model.fit_us}};
  if (model.geometry) out["geometry"] = geometry_json(*model.geometry);
  if (!model.datum_zeros.empty()) out["datum_zeros"] = datum_zeros_json(model.datum_zeros);
  return out.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string model_hash(const Model& model) {
  Model untimed = model;
  untimed.fit_us = 0;
  return content_hash(write_model_json(untimed));
}

Result<std::string> stored_model_hash(std::string_view text, std::string_view stored) {
  // In the order in which it was written: the hash is of the text.
  auto parsed = parse_ordered_json(text);
  if (!parsed || !parsed->is_object())
    return fail(ErrorCode::invalid_argument, reasons::kBadModel, "its text is no JSON object");
  Json& json = *parsed;
  if (json.contains("fit_us")) json["fit_us"] = 0.0;
  return content_hash_like(stored, json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Result<Model> read_model_json(std::string_view text) {
  DRIFTWISE_TRY(const auto json, parse_json(text));
  try {
    return read_whole(JsonPlace(json, ""));
  } catch (const JsonProblem& problem) {
    return fail(ErrorCode::invalid_argument, reasons::kBadModel,
                (problem.place.empty() ? std::string("the text") : problem.place) + ": found " +
                    problem.found + ", expected " + problem.expected);
  }
}

}  // namespace driftwise::formats
