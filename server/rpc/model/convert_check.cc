#include "server/rpc/model/convert_check.h"

#include "server/effects/term_order.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::CheckModelResponse::Verdict verdict_from(diagnosis::CheckVerdict verdict) {
  switch (verdict) {
    case diagnosis::CheckVerdict::not_judged:
      return v1::CheckModelResponse::VERDICT_NOT_JUDGED;
    case diagnosis::CheckVerdict::in_control:
      return v1::CheckModelResponse::VERDICT_IN_CONTROL;
    case diagnosis::CheckVerdict::recalibrate:
      return v1::CheckModelResponse::VERDICT_RECALIBRATE;
  }
  return v1::CheckModelResponse::VERDICT_UNSPECIFIED;
}

v1::CheckedRun checked_run_from(const diagnosis::CheckPoint& point) {
  v1::CheckedRun out;
  out.set_run_id(point.run.value);
  out.set_row_count(point.rows);
  out.set_excluded_row_count(point.excluded);
  out.set_effective_row_count(point.effective_rows);
  out.set_judged(point.judged);
  out.set_why_not(utf8_from(point.why_not));
  out.set_bias(point.bias);
  if (point.bias_limit) out.set_bias_limit(*point.bias_limit);
  out.set_sd(point.sd);
  out.set_sd_limit(point.sd_limit);
  out.set_u90(point.u90);
  out.set_a90(point.a90);
  if (point.ewma_bias) out.set_ewma_bias(*point.ewma_bias);
  if (point.ewma_bias_limit) out.set_ewma_bias_limit(*point.ewma_bias_limit);
  if (point.ewma_spread) out.set_ewma_spread(*point.ewma_spread);
  if (point.ewma_spread_limit) out.set_ewma_spread_limit(*point.ewma_spread_limit);
  for (const auto& sentence : point.out_of_control) out.add_out_of_control(sentence);
  return out;
}

}  // namespace

v1::CheckModelResponse check_from(const application::ModelCheck& check) {
  v1::CheckModelResponse out;
  out.set_model_id(check.model.value);
  out.set_verdict(verdict_from(check.report.verdict));
  for (const auto& reason : check.report.reasons) out.add_reasons(reason);
  for (const auto& output : check.report.outputs) {
    auto& added = *out.add_outputs();
    added.set_channel(output.channel.name());
    added.set_unit(output.unit);
    added.set_reference_sd(output.reference.sd);
    added.set_reference_dof(output.reference.dof);
    added.set_reference_source(output.reference.source);
    added.set_lag1_autocorrelation(output.reference.lag1_autocorrelation);
    for (const auto& point : output.points) {
      auto& run = *added.add_runs();
      run = checked_run_from(point);
      for (const auto& record : check.runs)
        if (record.id == point.run) {
          run.set_name(utf8_from(record.name));
          if (record.started.utc_ns != 0)
            *run.mutable_start_time() = timestamp_from(record.started);
        }
    }
  }
  return out;
}

v1::OfferOutcome offer_from(const calibration::OfferResult& offer) {
  v1::OfferOutcome out;
  out.set_offer(offer.name);
  out.set_output(offer.output);
  for (const auto& term : offer.taken) out.add_taken_terms(effects::notation(term));
  for (const auto& term : offer.left) out.add_left_terms(effects::notation(term));
  out.set_best_p(offer.best_p);
  if (offer.u90_validation_before) out.set_u90_validation_before(*offer.u90_validation_before);
  if (offer.u90_validation_after) out.set_u90_validation_after(*offer.u90_validation_after);
  if (offer.u90_validation_forced) out.set_u90_validation_forced(*offer.u90_validation_forced);
  if (offer.u90_blocks_before) out.set_u90_blocks_before(*offer.u90_blocks_before);
  if (offer.u90_blocks_after) out.set_u90_blocks_after(*offer.u90_blocks_after);
  if (offer.a90_validation_before) out.set_a90_validation_before(*offer.a90_validation_before);
  if (offer.a90_validation_after) out.set_a90_validation_after(*offer.a90_validation_after);
  if (offer.a90_validation_forced) out.set_a90_validation_forced(*offer.a90_validation_forced);
  if (offer.a90_blocks_before) out.set_a90_blocks_before(*offer.a90_blocks_before);
  if (offer.a90_blocks_after) out.set_a90_blocks_after(*offer.a90_blocks_after);
  return out;
}

}  // namespace driftwise::rpc
