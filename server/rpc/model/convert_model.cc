#include "server/rpc/model/convert_model.h"

#include <cmath>

#include "server/calibration/report/accuracy.h"
#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/effects/term_order.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/model/coefficient_unit.h"
#include "server/formats/model/model_json.h"
#include "server/rpc/shared/convert_accuracy.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::Accuracy accuracy_from(const calibration::Accuracy& accuracy, double factor) {
  v1::Accuracy out;
  out.set_rmse(accuracy.rmse * factor);
  out.set_u90_calibration(accuracy.u90_calibration * factor);
  if (accuracy.u90_validation) out.set_u90_validation(*accuracy.u90_validation * factor);
  if (accuracy.u90_blocks) out.set_u90_blocks(*accuracy.u90_blocks * factor);
  if (accuracy.u90_blocks_low) out.set_u90_blocks_low(*accuracy.u90_blocks_low * factor);
  if (accuracy.u90_blocks_high) out.set_u90_blocks_high(*accuracy.u90_blocks_high * factor);
  out.set_mean_calibration(accuracy.mean_calibration * factor);
  out.set_a90_calibration(accuracy.a90_calibration * factor);
  if (accuracy.mean_validation) out.set_mean_validation(*accuracy.mean_validation * factor);
  if (accuracy.a90_validation) out.set_a90_validation(*accuracy.a90_validation * factor);
  if (accuracy.mean_blocks) out.set_mean_blocks(*accuracy.mean_blocks * factor);
  if (accuracy.a90_blocks) out.set_a90_blocks(*accuracy.a90_blocks * factor);
  if (accuracy.a90_blocks_low) out.set_a90_blocks_low(*accuracy.a90_blocks_low * factor);
  if (accuracy.a90_blocks_high) out.set_a90_blocks_high(*accuracy.a90_blocks_high * factor);
  out.set_lag1_autocorrelation(accuracy.lag1_autocorrelation);
  out.set_effective_row_count(accuracy.effective_rows);
  if (accuracy.pure_error) out.set_pure_error(*accuracy.pure_error * factor);
  if (accuracy.lack_of_fit_f) out.set_lack_of_fit_f(*accuracy.lack_of_fit_f);
  if (accuracy.lack_of_fit_p) out.set_lack_of_fit_p(*accuracy.lack_of_fit_p);
  out.set_condition_index(accuracy.condition_index);
  out.set_slow_share(accuracy.slow_share);
  out.set_slow_row_count(accuracy.slow_rows);
  if (accuracy.model_f) out.set_model_f(*accuracy.model_f);
  if (accuracy.model_p) out.set_model_p(*accuracy.model_p);
  for (const auto& set : accuracy.validation_sets) {
    auto& added = *out.add_validation_sets();
    added.set_name(utf8_from(set.name));
    *added.mutable_figures() = figures_from({.rows = set.figures.rows,
                                             .mean = set.figures.mean * factor,
                                             .u90 = set.figures.u90 * factor,
                                             .a90 = set.figures.a90 * factor});
  }
  return out;
}

v1::ModelTerm term_from(const calibration::TermReport& report, double factor) {
  v1::ModelTerm out;
  out.set_term(effects::notation(report.term));
  out.set_included(report.in);
  out.set_coefficient(report.coefficient);
  out.set_standard_error(report.standard_error);
  out.set_t(report.t);
  out.set_p(report.p);
  out.set_note(report.note);
  if (report.in && report.standard_error_serial > 0)
    out.set_standard_error_serial(report.standard_error_serial);
  if (!report.in || report.term.is_constant())
    return out;                                 // what the constant lacks, and what is left out
  if (report.vif > 0) out.set_vif(report.vif);  // none of a term beside a geometry
  out.set_contribution_rms(report.contribution_rms * factor);
  out.set_contribution_max(report.contribution_max * factor);
  return out;
}

v1::ModelOutput output_from(const calibration::OutputModel& output, ModelDetail detail,
                            const calibration::Model& model) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  v1::ModelOutput out;
  out.set_channel(output.channel.name());
  out.set_unit(output.channel.unit);
  out.set_summary_unit(summary.unit);
  out.set_dof(output.dof);
  *out.mutable_accuracy() = accuracy_from(output.accuracy, summary.factor);
  if (detail == ModelDetail::summary) return out;
  for (const auto& report : output.report) {
    auto& added = *out.add_terms() = term_from(report, summary.factor);
    if (report.in) added.set_unit(formats::coefficient_unit(output, report.term, model));
  }
  for (const auto& step : output.history) {
    auto& added = *out.add_history();
    added.set_step(step.step);
    added.set_action(step.action);
    added.set_term(effects::notation(step.term));
    added.set_p(step.p);
    added.set_rmse(step.rmse * summary.factor);
    added.set_dof(step.dof);
  }
  return out;
}

v1::Lineage lineage_from(const calibration::Lineage& lineage) {
  v1::Lineage out;
  for (const RunId run : lineage.runs) out.add_run_ids(run.value);
  out.set_source(utf8_from(lineage.source));
  out.set_dataset_hash(lineage.dataset_hash);
  out.set_calibration_row_count(lineage.rows_calibration);
  out.set_validation_row_count(lineage.rows_validation);
  out.set_dropped_row_count(lineage.rows_dropped);
  out.set_excluded_row_count(lineage.rows_excluded);
  out.set_exclusions_hash(lineage.exclusions_hash);
  return out;
}

// The geometry in its first datum. An arm identified on several before 2026-12-02 stands in the
// mean of them, and its constants bring it back: they move where its base stands.
KinematicsDescription robot_of(const calibration::Model& model) {
  KinematicsDescription robot = model.geometry->robot;
  if (robot.kind != "serial-arm") return robot;
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms)  // constants of other terms count from where those are 0
      if (!term.is_constant() && !effects::datum_of(term)) return robot;
  for (const auto& output : model.outputs)
    for (std::size_t k = 0; k < output.terms.size(); ++k) {
      if (!output.terms[k].is_constant()) continue;
      const double mm = mm_from_nm(summary_unit(output.channel.unit).factor) *
                        output.coefficients[static_cast<Eigen::Index>(k)];
      if (output.channel.symbol == "x") robot.frame.x_mm += mm;
      if (output.channel.symbol == "y") robot.frame.y_mm += mm;
      if (output.channel.symbol == "z") robot.frame.z_mm += mm;
    }
  return robot;
}

v1::KinematicModel kinematics_from(const calibration::Model& model, ModelDetail detail) {
  const auto& geometry = *model.geometry;
  v1::KinematicModel out;
  out.set_kind(geometry.robot.kind);
  if (detail == ModelDetail::summary) return out;
  out.set_robot_toml(utf8_from(formats::write_robot_file(robot_of(model))));
  for (const auto& parameter : geometry.parameters) {
    auto& added = *out.add_parameters();
    added.set_name(parameter.name);
    added.set_value(parameter.value);
    if (parameter.free) added.set_standard_error(parameter.standard_error);
    added.set_note(utf8_from(parameter.note));
  }
  return out;
}

const v1::ModelOutput* find_output(const v1::Model& model, const std::string& channel) {
  for (const auto& output : model.outputs())
    if (output.channel() == channel) return &output;
  return nullptr;
}

void fill_cell(const v1::Model& model, const std::string& channel, const std::string& term,
               v1::CompareModelsResponse::Row::Cell& cell) {
  const auto* output = find_output(model, channel);
  if (output == nullptr) return;
  for (const auto& candidate : output->terms()) {
    if (candidate.term() != term) continue;
    cell.set_offered(true);
    cell.set_included(candidate.included());
    cell.set_coefficient(candidate.coefficient());
    cell.set_standard_error(candidate.standard_error());
    if (candidate.has_contribution_rms()) cell.set_contribution_rms(candidate.contribution_rms());
  }
}

bool has_row(const v1::CompareModelsResponse& response, const std::string& channel,
             const std::string& term) {
  for (const auto& row : response.rows())
    if (row.channel() == channel && row.term() == term) return true;
  return false;
}

v1::Model record_from(const ModelRecord& record, std::optional<ModelId> serving) {
  v1::Model out;
  out.set_id(record.id.value);
  out.set_name(record.name);
  out.set_hash(record.hash);
  if (record.parent) out.set_parent_model_id(record.parent->value);
  *out.mutable_create_time() = timestamp_from(record.created);
  out.set_created_by(record.created_by);
  out.set_note(record.note);
  out.set_serving(serving == record.id);
  out.set_damage(utf8_from(record.damage));
  return out;
}

void add_content(const calibration::Model& model, ModelDetail detail, v1::Model& out) {
  out.set_formula(model.formula);
  out.set_select(model.select);
  out.set_p_enter(model.p_enter);
  out.set_p_remove(model.p_remove);
  for (const auto& output : model.outputs) *out.add_outputs() = output_from(output, detail, model);
  for (const auto& range : model.domain) {
    auto& added = *out.add_domain();
    added.set_channel(range.channel.name());
    added.set_min(range.min);
    added.set_max(range.max);
  }
  if (model.geometry) *out.mutable_kinematics() = kinematics_from(model, detail);
  *out.mutable_lineage() = lineage_from(model.lineage);
  for (const auto& warning : model.warnings) out.add_warnings(warning);
  *out.mutable_fit_duration() = duration_from_s(model.fit_us * 1e-6);
}

}  // namespace

// Nothing of a damaged model is shown as its content.
Result<v1::Model> model_from(const ModelRecord& record, std::optional<ModelId> serving,
                             ModelDetail detail, const ModelRecord* before) {
  if (!record.damage.empty()) return record_from(record, serving);
  const auto model = formats::read_model_json(record.json);
  if (!model)
    return fail(ErrorCode::data_loss, reasons::kModelDamaged,
                "model " + std::to_string(record.id.value) +
                    " in the database cannot be read: " + model.error().message);
  v1::Model out = record_from(record, serving);
  add_content(*model, detail, out);
  std::vector<JudgedAccuracy> heading = calibration::heading_of(*model);
  if (before != nullptr && before->id != record.id)
    if (const auto earlier = formats::read_model_json(before->json))
      heading = calibration::heading_of(*model, *earlier);
  for (const auto& one : heading) *out.add_accuracy() = judged_from(one);
  return out;
}

v1::Model model_from(const application::ListedModel& listed, std::optional<ModelId> serving) {
  v1::Model out = record_from(listed.record, serving);
  if (!listed.summary) return out;
  add_content(*listed.summary, ModelDetail::summary, out);
  for (const auto& one : calibration::heading_of(*listed.summary))
    *out.add_accuracy() = judged_from(one);
  return out;
}

v1::Promotion promotion_from(const PromotionRecord& promotion) {
  v1::Promotion out;
  if (promotion.model) out.set_model_id(promotion.model->value);
  *out.mutable_promote_time() = timestamp_from(promotion.at);
  out.set_promoted_by(promotion.by);
  out.set_action(promotion.action == "rollback" ? v1::Promotion::ACTION_ROLLBACK
                                                : v1::Promotion::ACTION_PROMOTE);
  return out;
}

v1::CompareModelsResponse comparison_of(std::span<const v1::Model> models) {
  v1::CompareModelsResponse out;
  for (const auto& model : models) {
    for (const auto& output : model.outputs()) {
      for (const auto& term : output.terms()) {
        if (has_row(out, output.channel(), term.term())) continue;
        auto& row = *out.add_rows();
        row.set_channel(output.channel());
        row.set_term(term.term());
        for (const auto& each : models)
          fill_cell(each, output.channel(), term.term(), *row.add_cells());
      }
    }
    *out.add_models() = model;
  }
  return out;
}

}  // namespace driftwise::rpc
