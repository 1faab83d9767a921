#include "server/formats/diagnosis/stored_diagnosis.h"

#include <array>

#include "server/core/reasons.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "server/formats/text/json_place.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;
namespace dx = driftwise::diagnosis;
constexpr const char* kStoredSchema = "driftwise.stored_diagnosis.v1";

template <class T>
void put(Json& json, const char* key, const std::optional<T>& value) {
  if (value) json[key] = json_number(*value);
}
void put(Json& json, const char* key, const std::optional<dx::Interval>& value) {
  if (value) json[key] = {json_number(value->low), json_number(value->high)};
}
std::optional<double> maybe_number(const JsonPlace& from, const char* key) {
  return from.has(key) ? std::optional(from[key].number()) : std::nullopt;
}
std::optional<dx::Interval> maybe_interval(const JsonPlace& from, const char* key) {
  if (!from.has(key)) return std::nullopt;
  const auto pair = from[key];
  return dx::Interval{pair[std::size_t{0}].number(), pair[std::size_t{1}].number()};
}

template <class T, class Write>
Json list(const std::vector<T>& values, Write write) {
  Json json = Json::array();
  for (const auto& value : values) json.push_back(write(value));
  return json;
}
template <class Read>
auto read_list(const JsonPlace& from, Read read) {
  std::vector<std::invoke_result_t<Read, JsonPlace>> values;
  for (std::size_t i = 0; i < from.size(); ++i) values.push_back(read(from[i]));
  return values;
}
std::vector<double> read_numbers(const JsonPlace& from) {
  return read_list(from, [](const JsonPlace& one) { return one.number(); });
}
std::vector<std::string> read_texts(const JsonPlace& from) {
  return read_list(from, [](const JsonPlace& one) { return one.text(); });
}

constexpr std::array<std::string_view, 3> kVerdicts = {"adequate", "extended", "unexplained"};
constexpr std::array<std::string_view, 3> kAppliesTo = {"robot", "correction", "dataset"};

// names: in the order of the enum.
template <class Enum, std::size_t n>
Enum read_enum(const JsonPlace& from, const std::array<std::string_view, n>& names) {
  const auto text = from.text();
  for (std::size_t i = 0; i < n; ++i)
    if (names[i] == text) return static_cast<Enum>(i);
  from.refuse(std::string(names.front()) + " or another of its kind");
}
template <class Enum, std::size_t n>
std::string name_in(const std::array<std::string_view, n>& names, Enum value) {
  return std::string(names[static_cast<std::size_t>(value)]);
}

// Means and A90 by name: written with their U90.
template <class S, class Visit>
void each_mean(S& s, Visit visit) {
  visit("mean", s.mean);
  visit("a90", s.a90);
  visit("mean_calibration_before", s.mean_calibration_before);
  visit("mean_calibration_after", s.mean_calibration_after);
  visit("a90_calibration_before", s.a90_calibration_before);
  visit("a90_calibration_after", s.a90_calibration_after);
}
template <class S, class Visit>
void each_held_out(S& s, Visit visit) {
  visit("u90_validation_before", s.u90_validation_before);
  visit("u90_validation_after", s.u90_validation_after);
  visit("mean_validation_before", s.mean_validation_before);
  visit("mean_validation_after", s.mean_validation_after);
  visit("a90_validation_before", s.a90_validation_before);
  visit("a90_validation_after", s.a90_validation_after);
}
template <class O, class Visit>
void each_judged(O& o, Visit visit) {
  visit("u90_before", o.u90_before);
  visit("u90_after", o.u90_after);
  visit("mean_before", o.mean_before);
  visit("mean_after", o.mean_after);
  visit("a90_before", o.a90_before);
  visit("a90_after", o.a90_after);
}

Json summary_json(const dx::OutputSummary& s) {
  Json one{{"output", s.output},
           {"unit", s.unit},
           {"u90", json_number(s.u90)},
           {"u90_calibration_before", json_number(s.u90_calibration_before)},
           {"u90_calibration_after", json_number(s.u90_calibration_after)},
           {"noise_white_sd", json_number(s.noise_white_sd)},
           {"noise_slow_sd", json_number(s.noise_slow_sd)},
           {"noise_tau_s", json_number(s.noise_tau_s)}};
  put(one, "noise_floor_u90", s.noise_floor_u90);
  each_mean(s, [&](const char* key, double value) { one[key] = json_number(value); });
  each_held_out(s, [&](const char* key, const auto& value) { put(one, key, value); });
  one["explained_by"] = list(s.explained_by, [](const dx::Share& share) {
    return Json{{"variable", share.variable}, {"share", json_number(share.share)}};
  });
  return one;
}

dx::OutputSummary read_summary(const JsonPlace& from) {
  dx::OutputSummary s;
  s.output = from["output"].text();
  s.unit = from["unit"].text();
  s.u90 = from["u90"].number();
  s.u90_calibration_before = from["u90_calibration_before"].number();
  s.u90_calibration_after = from["u90_calibration_after"].number();
  s.noise_white_sd = from["noise_white_sd"].number();
  s.noise_slow_sd = from["noise_slow_sd"].number();
  s.noise_tau_s = from["noise_tau_s"].number();
  s.noise_floor_u90 = maybe_number(from, "noise_floor_u90");
  // Diagnoses without A90 had residuals about their mean.
  s.a90 = s.u90;
  s.a90_calibration_before = s.u90_calibration_before;
  s.a90_calibration_after = s.u90_calibration_after;
  each_mean(s, [&](const char* key, double& value) {
    if (from.has(key)) value = from[key].number();
  });
  each_held_out(
      s, [&](const char* key, std::optional<double>& value) { value = maybe_number(from, key); });
  s.explained_by = read_list(from["explained_by"], [](const JsonPlace& one) {
    return dx::Share{one["variable"].text(), one["share"].number()};
  });
  return s;
}

Json parameter_json(const dx::FoundParameter& p) {
  Json one{{"name", p.name}, {"value", json_number(p.value)}};
  put(one, "ci90", p.ci90);
  one["curve"] = list(p.curve, [](const dx::CurvePoint& point) {
    return Json{json_number(point.value), json_number(point.below_2lnl)};
  });
  if (!p.aliases.empty()) one["aliases"] = p.aliases;
  return one;
}

dx::FoundParameter read_parameter(const JsonPlace& from) {
  dx::FoundParameter p;
  p.name = from["name"].text();
  p.value = from["value"].number();
  p.ci90 = maybe_interval(from, "ci90");
  p.curve = read_list(from["curve"], [](const JsonPlace& point) {
    return dx::CurvePoint{point[std::size_t{0}].number(), point[std::size_t{1}].number()};
  });
  if (from.has("aliases"))
    p.aliases = read_list(from["aliases"], [](const JsonPlace& one) { return one.number(); });
  return p;
}

Json finding_output_json(const dx::FindingOutput& o) {
  Json one{{"output", o.output},
           {"unit", o.unit},
           {"amplitude", json_number(o.amplitude)},
           {"gain_2lnl", json_number(o.gain_2lnl)},
           {"shown", o.shown}};
  each_judged(o, [&](const char* key, const auto& value) { put(one, key, value); });
  put(one, "u90_after_ci90", o.u90_after_ci90);
  put(one, "a90_after_ci90", o.a90_after_ci90);
  put(one, "correction_rms", o.correction_rms);
  put(one, "correction_u90", o.correction_u90);
  one["coefficients"] = list(o.coefficients, [](double value) { return json_number(value); });
  return one;
}

dx::FindingOutput read_finding_output(const JsonPlace& from) {
  dx::FindingOutput o;
  o.output = from["output"].text();
  o.unit = from["unit"].text();
  o.amplitude = from["amplitude"].number();
  o.gain_2lnl = from["gain_2lnl"].number();
  o.shown = from["shown"].truth();
  each_judged(
      o, [&](const char* key, std::optional<double>& value) { value = maybe_number(from, key); });
  o.u90_after_ci90 = maybe_interval(from, "u90_after_ci90");
  o.a90_after_ci90 = maybe_interval(from, "a90_after_ci90");
  o.correction_rms = maybe_number(from, "correction_rms");
  o.correction_u90 = maybe_number(from, "correction_u90");
  o.coefficients = read_numbers(from["coefficients"]);
  return o;
}

Json stored_finding(const dx::Finding& f) {
  Json one{{"cause", f.cause},
           {"subject", f.subject},
           {"where", f.where},
           {"applies_to", name_in(kAppliesTo, f.applies_to)},
           {"parameters", list(f.parameters, parameter_json)}};
  one["terms"] =
      list(f.terms, [](const effects::Term& term) { return Json(effects::notation(term)); });
  one["rows"] = f.rows;
  one["p_adjusted"] = json_number(f.p_adjusted);
  one["log_likelihood_ratio"] = json_number(f.log_likelihood_ratio);
  one["indistinguishable_from"] = f.indistinguishable_from;
  one["outputs"] = list(f.outputs, finding_output_json);
  one["sentence"] = f.sentence;
  return one;
}

dx::Finding read_finding(const JsonPlace& from) {
  dx::Finding f;
  f.cause = from["cause"].text();
  f.subject = from["subject"].text();
  f.where = from["where"].text();
  f.applies_to = read_enum<effects::AppliesTo>(from["applies_to"], kAppliesTo);
  f.parameters = read_list(from["parameters"], read_parameter);
  f.terms = read_list(from["terms"], [](const JsonPlace& one) {
    auto term = parse_term(one.text());
    if (!term) one.refuse("a term of a formula");
    return std::move(*term);
  });
  f.rows = read_list(from["rows"],
                     [](const JsonPlace& one) { return static_cast<std::size_t>(one.integer(0)); });
  f.p_adjusted = from["p_adjusted"].number();
  f.log_likelihood_ratio = from["log_likelihood_ratio"].number();
  f.indistinguishable_from = read_texts(from["indistinguishable_from"]);
  f.outputs = read_list(from["outputs"], read_finding_output);
  f.sentence = from["sentence"].text();
  return f;
}

dx::SeparatingExperiment read_experiment(const JsonPlace& from) {
  return {from["why"].text(), maybe_number(from, "predicted_power"), from["trajectory_csv"].text(),
          from["estimated_s"].number()};
}

dx::Diagnosis read_diagnosis(const JsonPlace& from) {
  if (from["schema"].text() != kStoredSchema) from["schema"].refuse(kStoredSchema);
  dx::Diagnosis d;
  d.verdict = read_enum<dx::Verdict>(from["verdict"], kVerdicts);
  d.baseline_formula = from["baseline_formula"].text();
  d.extended_formula = from["extended_formula"].text();
  d.rows_calibration = static_cast<std::size_t>(from["rows_calibration"].integer(0));
  d.rows_held_out = static_cast<std::size_t>(from["rows_held_out"].integer(0));
  if (from.has("judged_on")) {
    const auto rows = judged_rows_from(from["judged_on"].text());
    if (!rows) from["judged_on"].refuse("validation, blocks, calibration or fresh");
    d.judged_on = *rows;
  }
  d.nulls = static_cast<int>(from["nulls"].integer(0, INT32_MAX));
  d.outputs = read_list(from["outputs"], read_summary);
  d.findings = read_list(from["findings"], read_finding);
  d.not_testable = read_list(from["not_testable"], [](const JsonPlace& one) {
    return dx::NotTestable{one["cause"].text(), one["why"].text()};
  });
  d.left_over = read_list(from["left_over"], [](const JsonPlace& one) {
    return dx::LeftOver{one["goes_with"].text(), one["p_adjusted"].number()};
  });
  if (from.has("separating_experiment"))
    d.separating_experiment = read_experiment(from["separating_experiment"]);
  d.warnings = read_texts(from["warnings"]);
  return d;
}

}  // namespace

std::string write_stored_diagnosis(const dx::Diagnosis& d) {
  Json json{{"schema", kStoredSchema},
            {"verdict", name_in(kVerdicts, d.verdict)},
            {"baseline_formula", d.baseline_formula},
            {"extended_formula", d.extended_formula},
            {"rows_calibration", d.rows_calibration},
            {"rows_held_out", d.rows_held_out},
            {"judged_on", to_string(d.judged_on)},
            {"nulls", d.nulls},
            {"outputs", list(d.outputs, summary_json)},
            {"findings", list(d.findings, stored_finding)}};
  json["not_testable"] = list(d.not_testable, [](const dx::NotTestable& one) {
    return Json{{"cause", one.cause}, {"why", one.why}};
  });
  json["left_over"] = list(d.left_over, [](const dx::LeftOver& one) {
    return Json{{"goes_with", one.goes_with}, {"p_adjusted", json_number(one.p_adjusted)}};
  });
  if (const auto& s = d.separating_experiment) {
    Json one{{"why", s->why},
             {"trajectory_csv", s->trajectory_csv},
             {"estimated_s", json_number(s->estimated_s)}};
    put(one, "predicted_power", s->predicted_power);
    json["separating_experiment"] = std::move(one);
  }
  json["warnings"] = d.warnings;
  return json.dump();
}

Result<dx::Diagnosis> read_stored_diagnosis(std::string_view text) {
  const auto json = parse_json(text);
  if (!json) return fail(ErrorCode::data_loss, reasons::kBadDiagnosis, json.error().message);
  try {
    return read_diagnosis(JsonPlace(*json, ""));
  } catch (const JsonProblem& problem) {
    return fail(ErrorCode::data_loss, reasons::kBadDiagnosis,
                "stored diagnosis: " + problem.place + ": found " + problem.found + ", expected " +
                    problem.expected);
  }
}

}  // namespace driftwise::formats
