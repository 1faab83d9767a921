#include "server/rpc/target/convert_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/compensation/correction_parts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

using compensation::arcsec_of;
using compensation::Variable;

std::optional<Variable> variable_of(std::string_view channel) {
  const auto underscore = channel.rfind('_');
  if (underscore == std::string_view::npos) return std::nullopt;
  const auto variable = compensation::variable_from(channel.substr(0, underscore));
  if (!variable) return std::nullopt;
  const std::string_view unit = channel.substr(underscore + 1);
  const bool rotation =
      *variable == Variable::rx || *variable == Variable::ry || *variable == Variable::rz;
  const std::string_view expected = *variable == Variable::force ? "N" : rotation ? "arcsec" : "mm";
  return unit == expected ? variable : std::nullopt;
}

v1::BudgetLine::Source source_from(compensation::UncertaintySource source) {
  using compensation::UncertaintySource;
  switch (source) {
    case UncertaintySource::fit:
      return v1::BudgetLine::SOURCE_FIT;
    case UncertaintySource::residual:
      return v1::BudgetLine::SOURCE_RESIDUAL;
    case UncertaintySource::temperatures:
      return v1::BudgetLine::SOURCE_TEMPERATURES;
    case UncertaintySource::laser:
      return v1::BudgetLine::SOURCE_LASER;
    case UncertaintySource::drift:
      return v1::BudgetLine::SOURCE_DRIFT;
    case UncertaintySource::beam_offset:
      return v1::BudgetLine::SOURCE_BEAM_OFFSET;
    case UncertaintySource::tilts:
      return v1::BudgetLine::SOURCE_TILTS;
    case UncertaintySource::beam_direction:
      return v1::BudgetLine::SOURCE_BEAM_DIRECTION;
    case UncertaintySource::mirror:
      return v1::BudgetLine::SOURCE_MIRROR;
    case UncertaintySource::force:
      return v1::BudgetLine::SOURCE_FORCE;
    case UncertaintySource::scale:
      return v1::BudgetLine::SOURCE_SCALE;
    case UncertaintySource::extrapolation:
      return v1::BudgetLine::SOURCE_EXTRAPOLATION;
  }
  return v1::BudgetLine::SOURCE_UNSPECIFIED;
}

void add_flags(const compensation::Snapshot& snapshot, const compensation::Target& target,
               v1::Target& out) {
  if (target.flags == 0) return;
  const auto add = [&](std::uint32_t flag, v1::Target::Flag named) {
    if ((target.flags & flag) != 0) out.add_flags(named);
  };
  add(compensation::kOutsideDomain, v1::Target::FLAG_OUTSIDE_DOMAIN);
  add(compensation::kStaleTemperature, v1::Target::FLAG_STALE_TEMPERATURE);
  add(compensation::kMissingTemperature, v1::Target::FLAG_MISSING_TEMPERATURE);
  add(compensation::kExpiredConditions, v1::Target::FLAG_EXPIRED_CONDITIONS);
  add(compensation::kUnanchoredDatum, v1::Target::FLAG_UNANCHORED_DATUM);
  add(compensation::kOutsideLimits, v1::Target::FLAG_OUTSIDE_LIMITS);
  add(compensation::kUnknownLimits, v1::Target::FLAG_UNKNOWN_LIMITS);
  add(compensation::kIgnoredCoordinate, v1::Target::FLAG_IGNORED_COORDINATE);
  for (std::size_t i = 0; i < target.outputs; ++i) {
    const auto name = snapshot.outputs[i].channel.name();
    if ((target.unreachable >> i & 1) != 0) out.add_unreachable_channels(name);
    if ((target.unlimited >> i & 1) != 0) out.add_unlimited_channels(name);
  }
  for (std::size_t i = 0; i < compensation::kVariables; ++i)
    if ((target.ignored >> i & 1) != 0)
      out.add_ignored_channels(compensation::channel_of(static_cast<Variable>(i)).name());
  add(compensation::kConfigurationChanged, v1::Target::FLAG_CONFIGURATION_CHANGED);
  add(compensation::kUnjudgedModel, v1::Target::FLAG_UNJUDGED_MODEL);
  add(compensation::kZeroOutsideDomain, v1::Target::FLAG_ZERO_OUTSIDE_DOMAIN);
  add(compensation::kDoubtfulModel, v1::Target::FLAG_DOUBTFUL_MODEL);
  for (std::size_t i = 0; i < snapshot.inputs.size(); ++i) {
    const std::uint64_t mine = std::uint64_t{1} << i;
    if ((target.outside & mine) != 0) out.add_outside_channels(snapshot.inputs[i].channel.name());
    if ((snapshot.zero_outside & mine) != 0)
      out.add_zero_outside_channels(snapshot.inputs[i].channel.name());
    if ((target.stale & mine) != 0) out.add_stale_channels(snapshot.inputs[i].channel.name());
    if ((target.missing & mine) != 0) out.add_missing_channels(snapshot.inputs[i].channel.name());
  }
}

void add_parts(const compensation::CorrectionParts& parts, v1::MotorCoordinate& out) {
  for (const auto& [source, nm] :
       {std::pair{v1::CorrectionPart::SOURCE_GEOMETRY, parts.geometry_nm},
        std::pair{v1::CorrectionPart::SOURCE_FORCE, parts.force_nm},
        std::pair{v1::CorrectionPart::SOURCE_TEMPERATURES, parts.temperatures_nm}}) {
    auto& part = *out.add_parts();
    part.set_source(source);
    part.set_nm(nm);
  }
}

void put_length(const compensation::Snapshot& snapshot, const compensation::Target& target,
                std::size_t i, v1::MotorCoordinate& out) {
  out.set_position_mm(target.q_mm[i]);
  out.set_u_nm(target.u_nm[i]);
  out.set_u90_nm(target.u90_nm(i));
  out.set_expanded_nm(target.expanded_nm(i));
  if ((target.unreachable >> i & 1) == 0) return;
  out.set_min_mm(snapshot.outputs[i].min_mm);
  out.set_max_mm(snapshot.outputs[i].max_mm);
}

void put_joint(const compensation::Snapshot& snapshot, const compensation::Target& target,
               std::size_t i, v1::MotorCoordinate& coordinate) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // no length: not 0 mm
  coordinate.set_position_mm(kNone);
  coordinate.set_u_nm(kNone);
  coordinate.set_u90_nm(kNone);
  coordinate.set_expanded_nm(kNone);
  v1::JointAngle& out = *coordinate.mutable_joint();
  out.set_position(target.q_mm[i]);
  if (std::isfinite(target.u_nm[i])) {
    const auto& channel = snapshot.outputs[i].channel;
    out.set_u_arcsec(arcsec_of(channel, target.u_nm[i]));
    out.set_u90_arcsec(arcsec_of(channel, target.u90_nm(i)));
    out.set_expanded_arcsec(arcsec_of(channel, target.expanded_nm(i)));
  }
  if ((target.unreachable >> i & 1) == 0) return;
  out.set_min(snapshot.outputs[i].min_mm);
  out.set_max(snapshot.outputs[i].max_mm);
}

}  // namespace

Result<compensation::TargetRequest> pose_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& pose, CellTime now) {
  compensation::TargetRequest request;
  request.now = now;
  for (const auto& value : pose) {
    const auto variable = variable_of(value.channel());
    const auto bad = [&](std::string reason, const char* what) {
      return fail(ErrorCode::invalid_argument, std::move(reason),
                  "pose: " + value.channel() + what);
    };
    if (!variable)
      return bad(reasons::kBadPose,
                 " is not a coordinate of a pose, expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec, "
                 "rz_arcsec or force_N");
    if (!value.has_value()) return bad(reasons::kMissingValue, " has no value");
    if (!std::isfinite(value.value())) return bad(reasons::kNotFinite, " is not a finite number");
    if ((request.given & compensation::bit(*variable)) != 0)
      return bad(reasons::kDuplicateChannel, " stands twice");
    request.set(*variable, value.value());
  }
  return request;
}

Result<void> take_near(const google::protobuf::RepeatedPtrField<v1::ChannelValue>& near,
                       compensation::TargetRequest& request) {
  for (const auto& value : near) {
    const auto bad = [&](std::string reason, const char* what) {
      return fail(ErrorCode::invalid_argument, std::move(reason),
                  "near: " + value.channel() + what);
    };
    if (!value.has_value()) return bad(reasons::kMissingValue, " has no value");
    if (!std::isfinite(value.value())) return bad(reasons::kNotFinite, " is not a finite number");
    switch (compensation::set_near(request, value.channel(), value.value())) {
      case compensation::NearName::taken:
        break;
      case compensation::NearName::twice:
        return bad(reasons::kDuplicateChannel, " stands twice");
      case compensation::NearName::unknown:
        return bad(reasons::kBadChannel, " is no joint angle, expected q1_deg to q9_deg or q1_rad");
    }
  }
  return {};
}

Result<void> answer_target(const compensation::Snapshot& snapshot,
                           const compensation::TargetRequest& request, bool with_budget,
                           v1::Target& out) {
  const compensation::Target target = compensation::compute_target(snapshot, request);
  if (target.refusal != compensation::Refusal::none)
    return tl::unexpected(compensation::refusal_error(snapshot, target));
  out.mutable_coordinates()->Reserve(static_cast<int>(target.outputs));
  for (std::size_t i = 0; i < target.outputs; ++i) {
    auto& coordinate = *out.add_coordinates();
    coordinate.set_channel(snapshot.outputs[i].channel.name());
    const bool joint = is_angle(snapshot.outputs[i].channel.unit);
    joint ? put_joint(snapshot, target, i, coordinate)
          : put_length(snapshot, target, i, coordinate);
    const auto parts = compensation::correction_parts(snapshot, request, i);
    if (parts) coordinate.set_correction_nm(parts->sum_nm());
    if (!with_budget) continue;
    if (parts) add_parts(*parts, coordinate);
    const auto budget =
        compensation::compute_budget(snapshot, request, i, {target.q_mm.data(), target.outputs});
    for (std::size_t line = 0; line < budget.lines; ++line) {
      auto& added = *coordinate.add_budget();
      added.set_source(source_from(budget.line[line].source));
      if (joint)
        added.set_u_arcsec(arcsec_of(snapshot.outputs[i].channel, budget.line[line].u_nm));
      else
        added.set_u_nm(budget.line[line].u_nm);
    }
  }
  out.set_model_id(snapshot.model.value);
  *out.mutable_conditions_time() = timestamp_from(snapshot.built_at);
  *out.mutable_valid_until_time() = timestamp_from(target.valid_until);
  add_flags(snapshot, target, out);
  return {};
}

Result<void> answer_pose(const compensation::Snapshot& snapshot,
                         const v1::EstimatePoseRequest& request, const Present& present,
                         CellTime now, v1::EstimatePoseResponse& out) {
  compensation::ForwardRequest wanted;
  DRIFTWISE_TRY(wanted.stated, pose_from(request.stated(), now));
  const auto force = present.find("force_N");
  if ((wanted.stated.given & compensation::bit(Variable::force)) == 0 && force != present.end())
    wanted.stated.set(Variable::force, force->second);

  Present motor;
  for (const auto& value : request.motor()) {
    const bool known =
        std::any_of(snapshot.outputs.begin(), snapshot.outputs.end(),
                    [&](const auto& output) { return output.channel.name() == value.channel(); });
    if (!known || !value.has_value())
      return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
                  "motor: " + value.channel() + " is no motor coordinate of model " +
                      std::to_string(snapshot.model.value) + " with a value, expected " +
                      (snapshot.outputs.empty() ? std::string("a model that serves")
                                                : snapshot.outputs[0].channel.name() + " ..."));
    motor[value.channel()] = value.value();
  }
  const bool stands = motor.empty();
  for (const auto& output : snapshot.outputs) {
    const Present& from = stands ? present : motor;
    const auto value = from.find(output.channel.name());
    if (value == from.end())
      return fail(ErrorCode::failed_precondition, reasons::kMissingValue,
                  output.channel.name() +
                      (stands ? " was not read lately: look at the controller, or state it"
                              : " is missing: state all motor coordinates of the model or none"));
    wanted.q_mm.push_back(value->second);
  }
  DRIFTWISE_TRY(const auto found, compensation::forward_pose(snapshot, wanted));

  for (const auto& coordinate : found.coordinates) {
    auto& told = *out.add_coordinates();
    told.set_channel(compensation::channel_of(coordinate.variable).name());
    told.set_value(coordinate.value);
    told.set_u(coordinate.u);
    const auto measured = present.find(told.channel());
    if (!stands || measured == present.end()) continue;
    told.set_measured(measured->second);
    told.set_discrepancy(measured->second - coordinate.value);
    told.set_agrees(std::abs(told.discrepancy()) <= 2 * coordinate.u);
  }
  for (std::size_t i = 0; i < wanted.q_mm.size(); ++i) {
    auto& told = *out.add_motor();
    told.set_channel(snapshot.outputs[i].channel.name());
    told.set_value(wanted.q_mm[i]);
  }
  out.set_model_id(snapshot.model.value);
  *out.mutable_conditions_time() = timestamp_from(snapshot.built_at);
  v1::Target flags;
  add_flags(snapshot, found.target, flags);
  *out.mutable_flags() = flags.flags();
  *out.mutable_outside_channels() = flags.outside_channels();
  *out.mutable_ignored_channels() = flags.ignored_channels();
  return {};
}

}  // namespace driftwise::rpc
