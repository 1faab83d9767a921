#include "server/rpc/queue/convert_queue.h"

#include "server/application/ports/run_plan.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/request_checks.h"

namespace driftwise::rpc {
namespace {

constexpr int kMostPriority = 1000;
constexpr std::size_t kMostConditionBytes = 256;

v1::QueueEntry::State queue_state(QueueState state) {
  switch (state) {
    case QueueState::waiting:
      return v1::QueueEntry::STATE_WAITING;
    case QueueState::running:
      return v1::QueueEntry::STATE_RUNNING;
    case QueueState::following:
      return v1::QueueEntry::STATE_FOLLOWING;
    case QueueState::done:
      return v1::QueueEntry::STATE_DONE;
    case QueueState::set_aside:
      return v1::QueueEntry::STATE_SET_ASIDE;
    case QueueState::removed:
      return v1::QueueEntry::STATE_REMOVED;
  }
  return v1::QueueEntry::STATE_UNSPECIFIED;
}

// UTC as it is meant: an entry waits for the wall clock.
Result<UtcTime> not_before_from(const google::protobuf::Timestamp& time) {
  constexpr std::int64_t kMost_s = 9'000'000'000;  // within 64 bits of nanoseconds
  if (time.seconds() < 0 || time.seconds() > kMost_s || time.nanos() < 0 ||
      time.nanos() > 999'999'999)
    return fail(ErrorCode::invalid_argument, reasons::kBadTime,
                "not_before_time: found " + std::to_string(time.seconds()) +
                    " s since 1970, expected an instant of this or the next two centuries");
  return UtcTime{time.seconds() * 1'000'000'000 + time.nanos()};
}

Result<void> check_priority(std::int32_t priority) {
  if (priority >= -kMostPriority && priority <= kMostPriority) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadNumber,
              "priority: found " + std::to_string(priority) + ", expected -1000 to 1000");
}

}  // namespace

v1::QueueHold queue_hold_from(const QueueHold& hold) {
  v1::QueueHold out;
  out.set_who(utf8_from(hold.who));
  out.set_why(utf8_from(hold.why));
  *out.mutable_begin_time() = timestamp_from(hold.at);
  return out;
}

v1::QueueEntry queue_entry_from(const application::QueueLine& line, CellTime now) {
  const auto& entry = line.entry;
  v1::QueueEntry out;
  out.set_id(entry.id.value);
  out.set_state(queue_state(entry.state));
  out.set_reason(utf8_from(entry.reason));
  out.set_waits_for(utf8_from(line.waits_for));
  out.set_name(utf8_from(entry.name));
  out.set_trajectory_name(utf8_from(entry.trajectory_name));
  out.set_row_count(entry.rows);
  out.set_compensate(entry.compensate);
  if (entry.compensate_with) out.set_compensate_model_id(entry.compensate_with->value);
  if (const auto plan = application::read_run_plan(entry.rules_json))
    out.set_setup(utf8_from(plan->setup));
  add_metadata(entry.metadata, *out.mutable_metadata());
  out.set_priority(entry.priority);
  if (entry.not_before.ns != 0) *out.mutable_not_before_time() = timestamp_from(entry.not_before);
  if (entry.after) out.set_after_entry_id(entry.after->value);
  out.set_condition(utf8_from(entry.condition));
  out.set_set_aside_on_failure(entry.on_failure == OnFailure::set_aside);
  if (entry.repeat_every_s > 0)
    *out.mutable_repeat_duration() = duration_from_s(entry.repeat_every_s);
  for (const auto& follow_up : entry.follow_ups) out.add_follow_ups(utf8_from(follow_up));
  for (const auto& result : entry.results) {
    auto& one = *out.add_results();
    const auto position = static_cast<std::size_t>(result.position);
    if (position < entry.follow_ups.size())
      one.set_follow_up(utf8_from(entry.follow_ups[position]));
    one.set_good(result.good);
    one.set_text(utf8_from(result.text));
    if (result.model) one.set_model_id(result.model->value);
    if (result.diagnosis) one.set_diagnosis_id(result.diagnosis->value);
    *one.mutable_time() = timestamp_from(result.at);
  }
  if (entry.run) out.set_run_id(entry.run->value);
  *out.mutable_create_time() = timestamp_from(entry.created);
  out.set_created_by(utf8_from(entry.created_by));
  if (entry.begun.utc_ns != 0) *out.mutable_begin_time() = timestamp_from(entry.begun);
  if (entry.ended.utc_ns != 0) *out.mutable_end_time() = timestamp_from(entry.ended);
  out.set_accepted(entry.accepted());
  if (!line.outlook) return out;
  *out.mutable_estimated_duration() = duration_from_s(line.outlook->run.expected_s);
  *out.mutable_estimated_band() = band_from(line.outlook->run);
  if (!line.outlook->end) return out;
  const auto after = [now](double s) { return timestamp_from(now + nanoseconds_from_s(s)); };
  *out.mutable_estimated_end_time() = after(line.outlook->end->expected_s);
  *out.mutable_earliest_end_time() = after(line.outlook->end->low_s);
  *out.mutable_latest_end_time() = after(line.outlook->end->high_s);
  return out;
}

Result<application::QueueDraft> queue_draft_from(const v1::AddQueueEntryRequest& request,
                                                 const RunRules& cell_rules) {
  for (const auto& good :
       {check_size(request.name(), kMostNameBytes, "name"),
        check_size(request.trajectory_name(), kMostNameBytes, "trajectory_name"),
        check_size(request.request_id(), kMostRequestIdBytes, "request_id"),
        check_size(request.setup(), kMostNameBytes, "setup"),
        check_size(request.condition(), kMostConditionBytes, "condition"),
        check_size(request.trajectory_text(), kMostTrajectoryBytes, "trajectory_text"),
        check_priority(request.priority())})
    DRIFTWISE_RETURN_IF_ERROR(good);
  if (request.trajectory_text().empty())
    return fail(ErrorCode::invalid_argument, reasons::kEmptyTrajectory,
                "trajectory_text: found nothing, expected a CSV file");
  application::QueueDraft draft;
  draft.name = clean_line(request.name());
  draft.trajectory_name = clean_line(request.trajectory_name());
  draft.trajectory_text = request.trajectory_text();
  draft.request_id = request.request_id();
  if (request.has_rules()) {
    DRIFTWISE_TRY(auto rules, rules_from(request.rules(), cell_rules));
    draft.rules = rules;
  }
  draft.setup = request.setup();
  draft.compensate = request.compensate();
  if (request.has_compensate_model_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(request.compensate_model_id(), "compensate_model_id"));
    if (!request.compensate())
      return fail(ErrorCode::invalid_argument, reasons::kModelWithoutCompensate,
                  "compensate_model_id names a model, but compensate is not set");
    draft.compensate_with = ModelId{request.compensate_model_id()};
  }
  DRIFTWISE_TRY(draft.metadata, metadata_from(request.metadata()));
  draft.priority = request.priority();
  if (request.has_not_before_time()) {
    DRIFTWISE_TRY(draft.not_before, not_before_from(request.not_before_time()));
  }
  if (request.has_after_entry_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_id(request.after_entry_id(), "after_entry_id"));
    draft.after = QueueEntryId{request.after_entry_id()};
  }
  draft.condition = request.condition();
  draft.on_failure = request.set_aside_on_failure() ? OnFailure::set_aside : OnFailure::hold;
  if (request.has_repeat_duration()) {
    DRIFTWISE_TRY(const auto every, nanoseconds_from(request.repeat_duration(), "repeat_duration"));
    draft.repeat_every_s = seconds_from(every);
  }
  for (const auto& follow_up : request.follow_ups()) {
    DRIFTWISE_RETURN_IF_ERROR(check_size(follow_up, kMostFormulaBytes, "follow_ups"));
    draft.follow_ups.push_back(follow_up);
  }
  return draft;
}

Result<application::QueueEdit> queue_edit_from(const v1::ChangeQueueEntryRequest& request) {
  application::QueueEdit edit;
  if (request.has_name()) {
    DRIFTWISE_TRY(edit.name, line_from(request.name(), kMostNameBytes, "name"));
  }
  if (request.has_priority()) {
    DRIFTWISE_RETURN_IF_ERROR(check_priority(request.priority()));
    edit.priority = request.priority();
  }
  if (request.has_not_before_time()) {
    DRIFTWISE_TRY(edit.not_before, not_before_from(request.not_before_time()));
  }
  if (request.has_after_entry_id()) {
    DRIFTWISE_RETURN_IF_ERROR(check_cursor(request.after_entry_id(), "after_entry_id"));
    edit.after = QueueEntryId{request.after_entry_id()};
  }
  if (request.has_condition()) {
    DRIFTWISE_RETURN_IF_ERROR(check_size(request.condition(), kMostConditionBytes, "condition"));
    edit.condition = request.condition();
  }
  if (request.has_set_aside_on_failure())
    edit.on_failure = request.set_aside_on_failure() ? OnFailure::set_aside : OnFailure::hold;
  if (request.has_repeat_duration()) {
    DRIFTWISE_TRY(const auto every, nanoseconds_from(request.repeat_duration(), "repeat_duration"));
    edit.repeat_every_s = seconds_from(every);
  }
  DRIFTWISE_TRY(edit.set_metadata, metadata_from(request.set_metadata()));
  for (const auto& key : request.remove_metadata()) {
    DRIFTWISE_RETURN_IF_ERROR(check_size(key, kMostNameBytes, "remove_metadata"));
    edit.remove_metadata.push_back(key);
  }
  return edit;
}

}  // namespace driftwise::rpc
