#include "server/rpc/run/convert_run.h"

#include <cmath>

#include "server/application/ports/run_plan.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {
namespace {

v1::Run::State state_from(RunState state) {
  switch (state) {
    case RunState::queued:
      return v1::Run::STATE_QUEUED;
    case RunState::running:
      return v1::Run::STATE_RUNNING;
    case RunState::paused:
      return v1::Run::STATE_PAUSED;
    case RunState::waiting:
      return v1::Run::STATE_WAITING;
    case RunState::done:
      return v1::Run::STATE_DONE;
    case RunState::aborted:
      return v1::Run::STATE_ABORTED;
    case RunState::failed:
      return v1::Run::STATE_FAILED;
  }
  return v1::Run::STATE_UNSPECIFIED;
}

v1::Attempt::Verdict verdict_from(Verdict verdict) {
  switch (verdict) {
    case Verdict::accepted:
      return v1::Attempt::VERDICT_ACCEPTED;
    case Verdict::reread:
      return v1::Attempt::VERDICT_REREAD;
    case Verdict::reapproach:
      return v1::Attempt::VERDICT_REAPPROACH;
    case Verdict::requeued:
      return v1::Attempt::VERDICT_REQUEUED;
    case Verdict::given_up:
      return v1::Attempt::VERDICT_GIVEN_UP;
    case Verdict::interrupted:
      return v1::Attempt::VERDICT_INTERRUPTED;
  }
  return v1::Attempt::VERDICT_UNSPECIFIED;
}

v1::RunHold::Kind kind_from(RunHold::Kind kind) {
  switch (kind) {
    case RunHold::Kind::none:
      break;
    case RunHold::Kind::pause:
      return v1::RunHold::KIND_PAUSE;
    case RunHold::Kind::stop:
      return v1::RunHold::KIND_STOP;
    case RunHold::Kind::trouble:
      return v1::RunHold::KIND_TROUBLE;
    case RunHold::Kind::restart:
      return v1::RunHold::KIND_RESTART;
    case RunHold::Kind::configuration:
      return v1::RunHold::KIND_CONFIGURATION;
    case RunHold::Kind::condition:
      return v1::RunHold::KIND_CONDITION;
  }
  return v1::RunHold::KIND_UNSPECIFIED;
}

v1::RunHold hold_from(const RunHold& hold) {
  v1::RunHold out;
  out.set_id(hold.id());
  out.set_kind(kind_from(hold.kind));
  out.set_who(utf8_from(hold.who));
  *out.mutable_begin_time() = timestamp_from(hold.at);
  out.set_reason(utf8_from(hold.reason));
  return out;
}

// One rule: absent leaves it, a value outside the range is refused with the field's name.
template <class T, class V>
bool take(bool present, V value, const char* field, double low, double high, T& rule,
          Error& error) {
  if (!present) return true;
  const double found = static_cast<double>(value);
  if (!std::isfinite(found) || found < low || found > high) {
    error = {ErrorCode::invalid_argument, reasons::kBadRule,
             std::string("rules.") + field + ": found " + formats::number_text(found) +
                 ", expected " + formats::number_text(low) + " to " + formats::number_text(high)};
    return false;
  }
  rule = static_cast<T>(value);
  return true;
}

}  // namespace

v1::Run run_from(const RunRecord& run) {
  v1::Run out;
  out.set_id(run.id.value);
  out.set_name(run.name);
  out.set_state(state_from(run.state));
  out.set_reason(utf8_from(run.reason));
  out.set_trajectory_name(run.trajectory_name);
  out.set_operator_name(run.operator_name);
  *out.mutable_create_time() = timestamp_from(run.created);
  if (run.started.utc_ns != 0) *out.mutable_start_time() = timestamp_from(run.started);
  if (run.ended.utc_ns != 0) *out.mutable_end_time() = timestamp_from(run.ended);
  if (run.started.utc_ns != 0 && run.ended.utc_ns != 0)
    *out.mutable_elapsed_duration() = duration_from(run.ended - run.started);
  out.set_row_count(run.rows);
  out.set_next_row(run.place.next_row);
  out.set_requeued_count(static_cast<std::int64_t>(run.place.requeued.size()));
  out.set_accepted_count(run.accepted);
  out.set_given_up_count(run.given_up);
  out.set_attempt_count(run.attempts);
  out.set_restart_count(run.restarts);
  *out.mutable_max_lag_duration() = duration_from_s(run.max_lag_s);
  out.set_config_hash(run.config_hash);
  out.set_request_id(run.request_id);
  const auto compensation = application::compensation_of(run);
  out.set_compensated(compensation.compensated);
  if (compensation.model) out.set_compensate_model_id(compensation.model->value);
  if (compensation.plan) out.set_compensate_plan_id(compensation.plan->value);
  out.set_setup(utf8_from(application::setup_of(run)));
  if (run.hold.kind != RunHold::Kind::none) *out.mutable_hold() = hold_from(run.hold);
  add_metadata(run.metadata, *out.mutable_metadata());
  if (run.queue_entry) out.set_queue_entry_id(run.queue_entry->value);
  return out;
}

void add_metadata(const RunMetadata& metadata,
                  google::protobuf::RepeatedPtrField<v1::MetadataItem>& out) {
  for (const auto& item : metadata) {
    auto& one = *out.Add();
    one.set_key(item.key);
    one.set_value(utf8_from(item.value));
  }
}

Result<RunMetadata> metadata_from(
    const google::protobuf::RepeatedPtrField<v1::MetadataItem>& items) {
  RunMetadata metadata;
  for (const auto& item : items) metadata.push_back({item.key(), item.value()});
  return checked_metadata(std::move(metadata));
}

Result<application::HoldAnswer> answer_from(const v1::HoldAnswer& answer) {
  DRIFTWISE_RETURN_IF_ERROR(
      check_size(answer.override_reason(), kMostNameBytes, "answer.override_reason"));
  return application::HoldAnswer{answer.hold_id(), answer.override_reason()};
}

v1::DurationBand band_from(const application::Outlook& outlook) {
  v1::DurationBand out;
  *out.mutable_low_duration() = duration_from_s(outlook.low_s);
  *out.mutable_high_duration() = duration_from_s(outlook.high_s);
  out.set_share(application::Outlook::kShare);
  out.set_run_count(outlook.runs);
  out.set_row_count(outlook.rows);
  return out;
}

v1::RunProgress progress_from(const application::RunProgress& progress) {
  v1::RunProgress out;
  *out.mutable_run() = run_from(progress.run);
  out.set_phase(progress.phase);
  out.set_row(shown_row(progress.row));
  out.set_line(progress.line);
  if (!is_missing(progress.last_spread_nm)) out.set_last_spread_nm(progress.last_spread_nm);
  if (!is_missing(progress.last_closure_nm)) out.set_last_closure_nm(progress.last_closure_nm);
  if (progress.estimated_end.utc_ns != 0)
    *out.mutable_estimated_end_time() = timestamp_from(progress.estimated_end);
  if (!is_over(progress.run.state)) {
    *out.mutable_remaining_duration() = duration_from_s(progress.remaining_s);
    *out.mutable_remaining_band() = band_from(progress.outlook);
    const auto end_after = [&progress](double s) {
      return timestamp_from(progress.estimated_end + nanoseconds_from_s(s - progress.remaining_s));
    };
    *out.mutable_earliest_end_time() = end_after(progress.outlook.low_s);
    *out.mutable_latest_end_time() = end_after(progress.outlook.high_s);
  }
  out.set_sequence(progress.sequence);
  return out;
}

v1::Point point_from(const PointRecord& point) {
  v1::Point out;
  out.set_id(point.id.value);
  out.set_run_id(point.run.value);
  out.set_row(shown_row(point.row));
  out.set_datum_id(point.datum.value);
  out.set_set(point.set == PointSet::validation ? v1::POINT_SET_VALIDATION
                                                : v1::POINT_SET_CALIBRATION);
  out.set_line(point.line);
  out.set_zero(point.zero);
  out.set_passage(point.passage);
  *out.mutable_measure_time() = timestamp_from(point.measured.utc);
  *out.mutable_dwell_duration() = duration_from_s(point.dwell_s);
  for (const double q_mm : point.commanded_mm) out.add_commanded_mm(q_mm);
  add_values(point.values, *out.mutable_values());
  return out;
}

v1::Attempt attempt_from(const AttemptRecord& attempt) {
  v1::Attempt out;
  out.set_row(shown_row(attempt.row));
  out.set_number(attempt.number);
  out.set_verdict(verdict_from(attempt.verdict));
  out.set_reason(utf8_from(attempt.reason));
  *out.mutable_start_time() = timestamp_from(attempt.started.utc);
  *out.mutable_end_time() = timestamp_from(attempt.ended.utc);
  if (!is_missing(attempt.spread_nm)) out.set_spread_nm(attempt.spread_nm);
  return out;
}

v1::Closure closure_from(const ClosureRecord& closure) {
  v1::Closure out;
  out.set_id(closure.id);
  out.set_run_id(closure.run.value);
  out.set_datum_id(closure.datum.value);
  out.set_line(closure.line);
  out.set_repetition(closure.repetition);
  *out.mutable_measure_time() = timestamp_from(closure.measured.utc);
  out.set_side(closure.side);
  out.set_expected_by(closure.by);
  // In the same order, from 1.
  out.set_decision(static_cast<v1::Closure::Decision>(static_cast<int>(closure.decision) + 1));
  out.set_sentence(closure.sentence);
  for (const auto& one : closure.coordinates) {
    auto& told = *out.add_coordinates();
    told.set_channel(one.channel);
    told.set_unit(one.channel.ends_with("_arcsec") ? "arcsec" : "nm");
    told.set_found(one.found);
    told.set_limit(one.limit);
    told.set_expected(one.expected);
    told.set_expected_sd(one.expected_sd);
    told.set_noise(one.noise);
    told.set_play(one.play);
    told.set_unexplained(one.unexplained());
  }
  return out;
}

v1::Datum datum_from(const DatumRecord& datum) {
  v1::Datum out;
  out.set_id(datum.id.value);
  if (datum.run) out.set_run_id(datum.run->value);
  *out.mutable_open_time() = timestamp_from(datum.opened.utc);
  out.set_reason(utf8_from(datum.reason));
  add_values(datum.values, *out.mutable_values());
  return out;
}

Result<RunRules> rules_from(const v1::RunRules& request, RunRules rules) {
  Error error;
  const bool good =
      take(request.has_readings_per_point(), request.readings_per_point(), "readings_per_point", 2,
           1000, rules.readings_per_point, error) &&
      take(request.has_max_spread_nm(), request.max_spread_nm(), "max_spread_nm", 1e-3, 1e6,
           rules.max_spread_nm, error) &&
      take(request.has_max_rereads(), request.max_rereads(), "max_rereads", 0, 1000,
           rules.max_rereads, error) &&
      take(request.has_max_reapproaches(), request.max_reapproaches(), "max_reapproaches", 0, 1000,
           rules.max_reapproaches, error) &&
      take(request.has_max_requeues(), request.max_requeues(), "max_requeues", 0, 1000,
           rules.max_requeues, error) &&
      take(request.has_reapproach_mm(), request.reapproach_mm(), "reapproach_mm", 0, 100,
           rules.reapproach_mm, error) &&
      take(request.has_in_position_nm(), request.in_position_nm(), "in_position_nm", 1, 1e6,
           rules.in_position_nm, error) &&
      take(request.has_max_given_up_share(), request.max_given_up_share(), "max_given_up_share", 0,
           1, rules.max_given_up_share, error) &&
      take(request.has_quiet_nm(), request.quiet_nm(), "quiet_nm", 1, 1e6, rules.quiet_nm, error);
  if (!good) return tl::unexpected(error);
  if (request.has_park()) rules.park = request.park();
  const auto duration = [&error](bool present, const google::protobuf::Duration& value,
                                 const char* field, double& rule_s) {
    if (!present) return true;
    const auto parsed = nanoseconds_from(value, field);
    if (!parsed) {
      error = parsed.error();
      return false;
    }
    rule_s = seconds_from(*parsed);
    return true;
  };
  if (!duration(request.has_settle_duration(), request.settle_duration(), "rules.settle_duration",
                rules.settle_s) ||
      !duration(request.has_move_timeout_duration(), request.move_timeout_duration(),
                "rules.move_timeout_duration", rules.move_timeout_s) ||
      !duration(request.has_max_temperature_age_duration(), request.max_temperature_age_duration(),
                "rules.max_temperature_age_duration", rules.max_temperature_age_s))
    return tl::unexpected(error);
  return rules;
}

}  // namespace driftwise::rpc
