#include "server/rpc/plan/convert_plan.h"

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

using plans::AnsweredBy;

v1::RobotAnswer::By by_from(AnsweredBy by) {
  switch (by) {
    case AnsweredBy::one:
      return v1::RobotAnswer::BY_ONE;
    case AnsweredBy::fine:
      return v1::RobotAnswer::BY_FINE;
    case AnsweredBy::coarse:
      return v1::RobotAnswer::BY_COARSE;
    case AnsweredBy::blend:
      return v1::RobotAnswer::BY_BLEND;
  }
  return v1::RobotAnswer::BY_UNSPECIFIED;
}

void add_joint_coordinates(const plans::JointSnapshot& snapshot, const plans::JointTarget& target,
                           v1::JointTarget& out) {
  for (std::size_t r = 0; r < target.robots; ++r)
    for (std::size_t i = 0; i < target.robot[r].outputs; ++i) {
      const std::size_t at = target.robot[r].first + i;
      const auto& output = snapshot.robots[r].fine.outputs[i];
      auto& coordinate = *out.add_coordinates();
      coordinate.set_channel(plans::channel_name(snapshot.robots[r].id, output.channel.name()));
      coordinate.set_position_mm(target.q_mm[at]);
      coordinate.set_u_nm(target.u_nm[at]);
      coordinate.set_u90_nm(target.u90_nm(at));
      coordinate.set_expanded_nm(target.expanded_nm(at));
      if ((target.robot[r].unreachable >> i & 1) == 0) continue;
      coordinate.set_min_mm(output.min_mm);
      coordinate.set_max_mm(output.max_mm);
    }
}

void add_joint_terms(const plans::JointSnapshot& snapshot, const plans::JointTarget& target,
                     v1::JointTarget& out) {
  for (std::size_t k = 0; k < target.terms; ++k) {
    const auto& term = target.term[k];
    const auto& step = snapshot.steps[term.step];
    const auto name = step.predicts.outputs[term.output].channel.name();
    const bool angle = step.predicts.outputs[term.output].channel.unit == "arcsec";
    auto& added = *out.add_terms();
    added.set_from_channel(plans::channel_name(snapshot.robots[step.from].id, name));
    if (term.added) added.set_to_channel(plans::channel_name(snapshot.robots[step.to].id, name));
    added.set_value(angle ? term.value : nm_from_mm(term.value));
    added.set_u(angle ? mm_from_nm(term.u) : term.u);
    added.set_unit(angle ? "arcsec" : "nm");
    added.set_model_id(step.predicts.model.value);
  }
}

void add_joint_robots(const plans::JointSnapshot& snapshot, const plans::JointTarget& target,
                      v1::JointTarget& out) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    const auto& answer = target.robot[r];
    auto& told = *out.add_robots();
    told.set_robot(robot.id);
    told.set_by(by_from(answer.by));
    told.set_fine_weight(answer.weight);
    told.set_model_id(robot.fine.model.value);
    if (robot.coarse) told.set_coarse_model_id(robot.coarse->model.value);
    told.set_difference_nm(answer.difference_nm);
    for (std::size_t v = 0; v < compensation::kVariables; ++v) {
      if ((robot.stated >> v & 1) == 0) continue;
      auto& value = *told.add_pose();
      value.set_channel(plans::channel_name(robot.id, static_cast<compensation::Variable>(v)));
      value.set_value(answer.pose[v]);
    }
  }
}

}  // namespace

v1::Plan plan_from(const PlanRecord& record, bool serves) {
  v1::Plan out;
  out.set_id(record.id.value);
  out.set_name(utf8_from(record.name));
  out.set_version(record.version);
  out.set_hash(record.hash);
  *out.mutable_create_time() = timestamp_from(record.created);
  out.set_created_by(utf8_from(record.created_by));
  out.set_note(utf8_from(record.note));
  out.set_serves(serves);
  for (const auto& [model, hash] : record.models) out.add_model_ids(model.value);
  return out;
}

v1::PlanPromotion plan_promotion_from(const PlanPromotionRecord& record) {
  v1::PlanPromotion out;
  if (record.plan) out.set_plan_id(record.plan->value);
  *out.mutable_promote_time() = timestamp_from(record.at);
  out.set_promoted_by(utf8_from(record.by));
  out.set_rollback(record.action == "rollback");
  return out;
}

void fill_plan_check(const application::PlanReport& report, v1::CheckPlanResponse& out) {
  for (const auto& finding : report.check.findings) {
    auto& told = *out.add_findings();
    told.set_refuses(finding.refuses);
    told.set_reason(finding.reason);
    told.set_message(utf8_from(finding.message));
  }
  for (const auto& band : report.check.bands) {
    auto& told = *out.add_bands();
    told.set_robot(band.robot);
    told.set_largest_difference_nm(band.largest_difference_nm);
    told.set_largest_channel(band.largest_channel);
    for (const auto& value : band.largest_at) {
      auto& at = *told.add_largest_at();
      at.set_channel(value.channel);
      at.set_value(value.value);
    }
    told.set_difference_arcsec(band.difference_arcsec);
    told.set_rate_share(band.rate_share);
    told.set_determinant_share(band.determinant_share.value_or(0));
    told.set_anchored(band.anchored);
    if (band.wider_to) told.set_wider_to(*band.wider_to);
    if (band.anchored_fade_to) told.set_anchored_fade_to(*band.anchored_fade_to);
  }
  for (const auto& step : report.steps) out.add_steps(utf8_from(step));
}

Result<plans::JointRequest> joint_request_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& pose,
    const plans::JointSnapshot& snapshot, CellTime now) {
  plans::JointRequest request;
  request.now = now;
  if (snapshot.robots.empty()) return request;  // no plan serves, which is the answer
  for (const auto& value : pose) {
    DRIFTWISE_TRY(const auto place, plans::joint_name(snapshot, value.channel()));
    if (!value.has_value())
      return fail(ErrorCode::invalid_argument, reasons::kMissingValue,
                  "pose: " + shown(value.channel()) + " has no value, expected a number");
    if ((request.given[place.robot] & compensation::bit(place.variable)) != 0)
      return fail(ErrorCode::invalid_argument, reasons::kDuplicateName,
                  "pose: found " + shown(value.channel()) + " twice, expected it once");
    request.set(place.robot, place.variable, value.value());
  }
  return request;
}

Result<void> answer_joint_target(const plans::JointSnapshot& snapshot,
                                 const plans::JointRequest& request, v1::JointTarget& out) {
  const auto target = plans::compute_joint_target(snapshot, request);
  if (target.refusal != compensation::Refusal::none)
    return tl::unexpected(plans::joint_refusal_error(snapshot, target));
  add_joint_coordinates(snapshot, target, out);
  add_joint_terms(snapshot, target, out);
  add_joint_robots(snapshot, target, out);
  out.set_plan_id(snapshot.plan.value);
  *out.mutable_conditions_time() = timestamp_from(snapshot.built_at);
  *out.mutable_valid_until_time() = timestamp_from(target.valid_until);
  for (auto& flag : plans::describe_joint_flags(snapshot, target)) out.add_flags(std::move(flag));
  return {};
}

}  // namespace driftwise::rpc
