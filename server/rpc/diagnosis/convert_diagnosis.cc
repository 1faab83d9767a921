#include "server/rpc/diagnosis/convert_diagnosis.h"

#include <nlohmann/json.hpp>

#include "server/diagnosis/report/heading.h"
#include "server/effects/term_order.h"
#include "server/formats/diagnosis/diagnosis_json.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/rpc/shared/convert_accuracy.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/row_ranges.h"

namespace driftwise::rpc {
namespace {

namespace dx = driftwise::diagnosis;

v1::Diagnosis::State diagnosis_state_from(JobState state) {
  return static_cast<v1::Diagnosis::State>(static_cast<int>(state) + 1);  // in the same order
}
v1::Improvement::State improvement_state_from(JobState state) {
  return static_cast<v1::Improvement::State>(static_cast<int>(state) + 1);
}
v1::Verdict verdict_from(dx::Verdict verdict) {
  return static_cast<v1::Verdict>(static_cast<int>(verdict) + 1);
}

template <class Message>
void set_interval(Message* out, const std::optional<dx::Interval>& interval) {
  out->set_low(interval->low);
  out->set_high(interval->high);
}

void add_output(const dx::OutputSummary& from, v1::OutputDiscrepancy& out) {
  out.set_output(from.output);
  out.set_unit(from.unit);
  out.set_u90(from.u90);
  if (from.noise_floor_u90) out.set_noise_floor(*from.noise_floor_u90);
  out.set_u90_calibration_before(from.u90_calibration_before);
  out.set_u90_calibration_after(from.u90_calibration_after);
  if (from.u90_validation_before) out.set_u90_validation_before(*from.u90_validation_before);
  if (from.u90_validation_after) out.set_u90_validation_after(*from.u90_validation_after);
  out.set_mean(from.mean);
  out.set_a90(from.a90);
  out.set_mean_calibration_before(from.mean_calibration_before);
  out.set_mean_calibration_after(from.mean_calibration_after);
  out.set_a90_calibration_before(from.a90_calibration_before);
  out.set_a90_calibration_after(from.a90_calibration_after);
  if (from.mean_validation_before) out.set_mean_validation_before(*from.mean_validation_before);
  if (from.mean_validation_after) out.set_mean_validation_after(*from.mean_validation_after);
  if (from.a90_validation_before) out.set_a90_validation_before(*from.a90_validation_before);
  if (from.a90_validation_after) out.set_a90_validation_after(*from.a90_validation_after);
  out.set_noise_white_sd(from.noise_white_sd);
  out.set_noise_slow_sd(from.noise_slow_sd);
  out.set_noise_tau_s(from.noise_tau_s);
  for (const auto& share : from.explained_by) {
    auto& one = *out.add_explained_by();
    one.set_variable(share.variable);
    one.set_marginal_share(share.share);
  }
}

void add_parameter(const dx::FoundParameter& from, DiagnosisDetail detail,
                   v1::FindingParameter& out) {
  out.set_name(from.name);
  out.set_value(from.value);
  if (from.ci90) set_interval(out.mutable_ci90(), from.ci90);
  if (detail == DiagnosisDetail::summary) return;
  for (const auto& point : from.curve) {
    out.add_curve_value(point.value);
    out.add_curve_2lnl(point.below_2lnl);
  }
}

void add_finding(const dx::Finding& from, int number, DiagnosisDetail detail, v1::Finding& out) {
  out.set_number(number);
  out.set_cause(from.cause);
  out.set_applies_to(std::string(effects::to_string(from.applies_to)));
  out.set_where(from.where);
  out.set_subject(from.subject);
  for (const auto& parameter : from.parameters)
    add_parameter(parameter, detail, *out.add_parameters());
  out.set_p_adjusted(from.p_adjusted);
  out.set_log_likelihood_ratio(from.log_likelihood_ratio);
  for (const auto& other : from.indistinguishable_from) out.add_indistinguishable_from(other);
  for (const auto& output : from.outputs) {
    auto& one = *out.add_outputs();
    one.set_output(output.output);
    one.set_unit(output.unit);
    one.set_amplitude(output.amplitude);
    if (output.u90_before) one.set_u90_before(*output.u90_before);
    if (output.u90_after) one.set_u90_after(*output.u90_after);
    if (output.u90_after_ci90) set_interval(one.mutable_u90_after_ci90(), output.u90_after_ci90);
    if (output.mean_before) one.set_mean_before(*output.mean_before);
    if (output.mean_after) one.set_mean_after(*output.mean_after);
    if (output.a90_before) one.set_a90_before(*output.a90_before);
    if (output.a90_after) one.set_a90_after(*output.a90_after);
    if (output.a90_after_ci90) set_interval(one.mutable_a90_after_ci90(), output.a90_after_ci90);
    one.set_shown(output.shown);
    if (output.correction_rms) one.set_correction_rms(*output.correction_rms);
    if (output.correction_u90) one.set_correction_u90(*output.correction_u90);
  }
  out.set_sentence(utf8_from(from.sentence));
  for (const auto& term : from.terms) out.add_terms(effects::notation(term));
}

void add_found(const dx::Diagnosis& from, DiagnosisDetail detail, v1::Diagnosis& out) {
  out.set_extended_formula(from.extended_formula);
  out.set_verdict(verdict_from(from.verdict));
  for (const auto& output : from.outputs) add_output(output, *out.add_outputs());
  for (const auto& one : dx::heading_of(from)) *out.add_accuracy() = judged_from(one);
  int number = 0;
  for (const auto& finding : from.findings)
    add_finding(finding, ++number, detail, *out.add_findings());
  for (const auto& one : from.not_testable) {
    auto& row = *out.add_not_testable();
    row.set_cause(one.cause);
    row.set_why(utf8_from(one.why));
  }
  for (const auto& rest : from.left_over) {
    auto& row = *out.add_left_over();
    row.set_goes_with(rest.goes_with);
    row.set_p_adjusted(rest.p_adjusted);
  }
  if (const auto& experiment = from.separating_experiment) {
    auto& to = *out.mutable_separating_experiment();
    to.set_why(utf8_from(experiment->why));
    if (experiment->predicted_power) to.set_predicted_power(*experiment->predicted_power);
    to.set_trajectory_text(experiment->trajectory_csv);
    to.set_estimated_s(experiment->estimated_s);
  }
  for (const auto& warning : from.warnings) out.add_warnings(utf8_from(warning));
}

template <class List>
void add_numbers(const std::vector<double>& values, List& out) {
  out.Add(values.begin(), values.end());
}

}  // namespace

v1::Diagnosis diagnosis_from(const application::DiagnosisView& view, DiagnosisDetail detail) {
  const auto& record = view.record;
  v1::Diagnosis out;
  out.set_id(record.id.value);
  out.set_state(diagnosis_state_from(record.state));
  out.set_reason(utf8_from(record.reason));
  *out.mutable_create_time() = timestamp_from(record.created);
  if (record.ended.utc_ns != 0) *out.mutable_end_time() = timestamp_from(record.ended);
  out.set_created_by(utf8_from(record.created_by));
  for (const RunId run : record.runs) out.add_run_ids(run.value);
  if (record.model) out.set_model_id(record.model->value);
  out.set_baseline_formula(utf8_from(record.baseline));
  out.set_robot(formats::robot_of_formula(record.baseline));
  if (view.found) {
    add_found(*view.found, detail, out);
    if (detail == DiagnosisDetail::whole)
      out.set_json(utf8_from(formats::diagnosis_json(*view.found, view.origins)
                                 .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  }
  if (view.extension) *out.mutable_extension() = extension_from(*view.extension);
  return out;
}

v1::DiagnosisProgress diagnosis_progress_from(const application::DiagnosisProgress& progress) {
  v1::DiagnosisProgress out;
  out.set_diagnosis_id(progress.id.value);
  out.set_state(diagnosis_state_from(progress.state));
  out.set_step(utf8_from(progress.step));
  out.set_fraction(progress.fraction);
  return out;
}

v1::DiscrepancyRows rows_from(const formats::DiscrepancyRows& rows) {
  v1::DiscrepancyRows out;
  add_numbers(rows.time_s, *out.mutable_time_s());
  for (const std::uint8_t validation : rows.validation) out.add_validation(validation != 0);
  add_numbers(rows.line, *out.mutable_line());
  for (const auto& column : rows.variables) {
    auto& to = *out.add_variables();
    to.set_symbol(column.symbol);
    to.set_unit(column.unit);
    add_numbers(column.values, *to.mutable_values());
  }
  for (const auto& output : rows.outputs) {
    auto& to = *out.add_outputs();
    to.set_output(output.output);
    to.set_unit(output.unit);
    add_numbers(output.before, *to.mutable_before());
    add_numbers(output.after, *to.mutable_after());
  }
  return out;
}

v1::Extension extension_from(const ExtensionRecord& extension) {
  v1::Extension out;
  out.set_diagnosis_id(extension.diagnosis.value);
  for (const int number : extension.findings) out.add_finding_numbers(number);
  if (extension.model) out.set_model_id(extension.model->value);
  out.set_promoted(extension.promoted);
  if (extension.correction) out.set_correction_id(extension.correction->value);
  for (const auto& rows : extension.excluded) add_excluded_ranges(rows, out);
  *out.mutable_accept_time() = timestamp_from(extension.accepted);
  out.set_accepted_by(utf8_from(extension.accepted_by));
  if (!extension.stands()) *out.mutable_undo_time() = timestamp_from(extension.undone);
  return out;
}

v1::Improvement improvement_from(const ImprovementRecord& record) {
  v1::Improvement out;
  out.set_id(record.id.value);
  out.set_state(improvement_state_from(record.state));
  out.set_reason(utf8_from(record.reason));
  *out.mutable_create_time() = timestamp_from(record.created);
  if (record.ended.utc_ns != 0) *out.mutable_end_time() = timestamp_from(record.ended);
  out.set_created_by(utf8_from(record.created_by));
  out.set_trajectory_name(utf8_from(record.trajectory_name));
  out.set_formula(utf8_from(record.formula));
  for (const auto& turn : record.turns) {
    auto& to = *out.add_turns();
    to.set_number(turn.number);
    for (const RunId run : turn.runs) to.add_run_ids(run.value);
    if (turn.model) to.set_model_id(turn.model->value);
    if (turn.diagnosis) to.set_diagnosis_id(turn.diagnosis->value);
    to.set_what(utf8_from(turn.what));
    for (const auto& gain : turn.gains) {
      auto& one = *to.add_gains();
      one.set_output(gain.output);
      one.set_unit(gain.unit);
      one.set_u90_before(gain.before.u90);
      if (gain.predicted) one.set_u90_predicted(gain.predicted->u90);
      if (gain.measured) one.set_u90_measured(gain.measured->u90);
      *one.mutable_before() = figures_from(gain.before);
      if (gain.predicted) *one.mutable_predicted() = figures_from(*gain.predicted);
      if (gain.measured_before)
        *one.mutable_measured_before() = figures_from(*gain.measured_before);
      if (gain.measured) *one.mutable_measured() = figures_from(*gain.measured);
    }
    *to.mutable_start_time() = timestamp_from(turn.started);
    if (turn.ended.utc_ns != 0) *to.mutable_end_time() = timestamp_from(turn.ended);
  }
  return out;
}

v1::ImprovementProgress improvement_progress_from(
    const application::ImprovementProgress& progress) {
  v1::ImprovementProgress out;
  out.set_improvement_id(progress.id.value);
  out.set_state(improvement_state_from(progress.state));
  out.set_turn(progress.turn);
  out.set_step(utf8_from(progress.step));
  return out;
}

}  // namespace driftwise::rpc
