#include "server/rpc/configuration/convert_provenance.h"

#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/row_ranges.h"

namespace driftwise::rpc {
namespace {

v1::LengthChange length_from(const LengthChange& change) {
  v1::LengthChange out;
  out.set_run_id(change.run.value);
  out.set_run_name(utf8_from(change.run_name));
  out.set_channel(change.channel);
  if (change.from.utc_ns != 0) *out.mutable_from_time() = timestamp_from(change.from);
  out.set_row_count(change.rows);
  out.set_largest_nm(change.largest_nm);
  out.set_rms_nm(change.rms_nm);
  out.set_diagnosed(change.diagnosed);
  return out;
}

}  // namespace

v1::ConfigurationChange change_from(const formats::ConfigurationChange& change) {
  v1::ConfigurationChange out;
  out.set_place(utf8_from(change.place));
  out.set_key(utf8_from(change.key));
  out.set_before(utf8_from(change.before));
  out.set_after(utf8_from(change.after));
  out.set_asks(change.asks);
  for (const auto& symbol : change.affects) out.add_affects(utf8_from(symbol));
  return out;
}

v1::UsedConfiguration used_from(const UsedConfiguration& used) {
  v1::UsedConfiguration out;
  out.set_hash(used.hash);
  if (used.from.utc_ns != 0) *out.mutable_from_time() = timestamp_from(used.from);
  return out;
}

v1::ConfigurationStart start_from(const ConfigurationStart& start) {
  v1::ConfigurationStart out;
  out.set_id(start.id);
  out.set_hash(start.hash);
  out.set_version(start.version);
  *out.mutable_start_time() = timestamp_from(start.at.utc);
  out.set_before_hash(start.before_hash);
  for (const auto& change : formats::read_changes_json(start.changes_json))
    *out.add_changes() = change_from(change);
  out.set_asks(start.asks);
  if (start.accepted.utc_ns != 0) *out.mutable_accept_time() = timestamp_from(start.accepted);
  out.set_accepted_by(utf8_from(start.accepted_by));
  out.set_note(utf8_from(start.note));
  return out;
}

v1::CorrectionMark mark_from(const CorrectionRecord& correction) {
  v1::CorrectionMark out;
  out.set_correction_id(correction.id.value);
  if (correction.diagnosis) out.set_diagnosis_id(correction.diagnosis->value);
  *out.mutable_accept_time() = timestamp_from(correction.created);
  out.set_accepted_by(utf8_from(correction.created_by));
  if (!correction.in_force()) *out.mutable_end_time() = timestamp_from(correction.ended);
  out.set_ended_by(utf8_from(correction.ended_by));
  for (const auto& change : correction.changes) *out.add_changes() = length_from(change);
  return out;
}

v1::PreviewExtensionResponse preview_from(const application::ExtensionPreview& preview) {
  v1::PreviewExtensionResponse out;
  for (const int number : preview.findings) out.add_finding_numbers(number);
  out.set_formula(utf8_from(preview.formula));
  out.set_extends_model(preview.extends_model);
  for (const auto& change : preview.changes) *out.add_changes() = length_from(change);
  out.set_earlier_runs(preview.earlier_runs);
  out.set_later_runs(preview.later_runs);
  for (const auto& rows : preview.excluded) add_excluded_ranges(rows, out);
  for (const auto& sentence : preview.further) out.add_further(utf8_from(sentence));
  for (const auto& question : preview.promotion_questions)
    out.add_promotion_questions(utf8_from(question));
  for (const auto& question : preview.questions_for_a_reason)
    out.add_questions_for_a_reason(utf8_from(question));
  for (const auto& sentence : preview.sentences) out.add_sentences(utf8_from(sentence));
  return out;
}

void add_ground(const application::RunGround& ground, bool whole, v1::Run& out) {
  if (whole)
    for (const auto& used : ground.configurations) *out.add_configurations() = used_from(used);
  for (const auto& correction : ground.corrections) *out.add_corrections() = mark_from(correction);
}

void add_ground(const application::ModelGround& ground, v1::GetModelResponse& out) {
  out.set_present_config_hash(ground.present_hash);
  for (const auto& used : ground.configurations) *out.add_configurations() = used_from(used);
  if (!ground.configurations.empty()) out.set_config_hash(ground.configurations.back().hash);
  for (const auto& change : ground.changes_since) *out.add_changes_since() = change_from(change);
  for (const auto& correction : ground.corrections)
    *out.mutable_model()->add_corrections() = mark_from(correction);
  for (const auto& question : ground.questions_for_a_reason)
    out.add_questions_for_a_reason(utf8_from(question));
  for (const auto& question : ground.promotion_questions)
    out.add_promotion_questions(utf8_from(question));
}

}  // namespace driftwise::rpc
