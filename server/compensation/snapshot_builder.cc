#include "server/compensation/snapshot_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/calibration/model/model_units.h"
#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::compensation {
namespace {

tl::unexpected<Error> not_servable(const std::string& reason, const std::string& message) {
  return fail(ErrorCode::failed_precondition, reason, message);
}

calibration::ChannelRange widened(calibration::ChannelRange range) {
  const double slack = kDomainSlack * (range.max - range.min);
  return {range.channel, range.min - slack, range.max + slack};
}

// Allowing for autocorrelation where the model says so; a model of the first version does not.
const Eigen::MatrixXd& uncertainty_of(const calibration::OutputModel& output) {
  return output.covariance_serial.size() > 0 ? output.covariance_serial : output.covariance;
}

// Soft limits of an axis; none: the cell file has no such axis (one in mm is no joint of an arm),
// or no limits of it.
std::optional<std::pair<double, double>> travel_of(const Channel& channel,
                                                   const CellDescription& cell) {
  for (const auto& device : cell.devices)
    for (const auto& axis : device.axes())
      if (axis.channel.symbol == channel.symbol &&
          is_angle(axis.channel.unit) == is_angle(channel.unit) && axis.min_mm < axis.max_mm)
        return std::pair(axis.min_mm, axis.max_mm);
  return std::nullopt;
}

// Targets of an arm have its geometry alone, which then has to be all of the model in its first
// datum.
Result<void> check_geometry_alone(const calibration::Model& model) {
  for (const auto& output : model.outputs)
    for (std::size_t k = 0; k < output.terms.size(); ++k) {
      const auto& term = output.terms[k];
      const double coefficient = output.coefficients[static_cast<Eigen::Index>(k)];
      if (effects::datum_of(term) || (term.is_constant() && coefficient == 0)) continue;
      const bool constant = term.is_constant();
      return not_servable(
          reasons::kTermNotServable,
          (constant ? "a constant of " + digits_text(coefficient, 6) + " " + output.channel.unit
                    : "term " + effects::notation(term)) +
              " of " + output.channel.symbol +
              " stands beside the geometry of an arm, whose targets have the geometry alone" +
              (constant ? " and would be off by it: identify it again, which puts the geometry "
                          "into the first datum of the rows (without --model)"
                        : ": identify it without --model, or its joints with --joint-errors"));
    }
  return {};
}

}  // namespace

Result<SnapshotBuilder> SnapshotBuilder::create(calibration::Model model, ModelId id,
                                                const CellDescription& cell, Gives gives) {
  SnapshotBuilder made;
  made.gives_ = gives;
  made.model_ = std::move(model);
  made.id_ = id;
  made.rules_ = cell.serving;
  made.column_per_unit_.fill(1.0);
  if (made.model_.geometry)
    DRIFTWISE_RETURN_IF_ERROR(made.add_geometry());
  else
    for (const auto& output : made.model_.outputs)
      DRIFTWISE_RETURN_IF_ERROR(made.add_output(output));

  for (const auto& channel : made.slow_.channels()) {
    const auto range = widened(made.range_of(channel));
    if (const double width = range.max - range.min; std::isfinite(width))
      made.slow_.set_before_first(made.slow_inputs_.size(), width / std::sqrt(12.0));
    made.slow_inputs_.push_back({range.min, range.max, 0.0});
    for (const auto& device : cell.devices)
      for (const auto& probe : device.probes()) {
        if (probe.channel.symbol != channel.symbol) continue;
        const auto to_unit = calibration::to_model_unit(probe.channel, channel);
        if (!to_unit) continue;
        made.slow_.set_read_as(made.slow_inputs_.size() - 1, {probe.channel.name(), *to_unit});
        made.slow_inputs_.back().u = probe.u_k;  // degC and K: the same difference
      }
  }
  if (gives == Gives::motors)
    for (auto& output : made.outputs_)
      if (!output.travel_mm) output.travel_mm = travel_of(output.channel, cell);
  for (auto& output : made.outputs_) {
    output.absorbed.resize(made.slow_.channels().size());
    for (const auto& fitted : made.model_.outputs)
      if (fitted.channel.symbol == output.channel.symbol)
        made.add_uncertainty(fitted, cell, output);
  }
  if (made.law_ && made.law_->absolute()) made.add_errors_of_arm(cell);
  made.add_own_scatter(cell);
  if (made.outputs_.empty() || made.outputs_.size() > kMaxOutputs ||
      made.basis_.size() > kMaxBasis ||
      made.fast_inputs_.size() + made.slow_inputs_.size() + made.standing_.size() > kMaxInputs)
    return not_servable(
        reasons::kModelTooLarge,
        "the model has " + std::to_string(made.outputs_.size()) + " outputs, " +
            std::to_string(made.basis_.size()) + " products of pose and force and " +
            std::to_string(made.fast_inputs_.size() + made.slow_inputs_.size()) + " inputs; 1 to " +
            std::to_string(kMaxOutputs) + ", " + std::to_string(kMaxBasis) + " and " +
            std::to_string(kMaxInputs) + " can be served");
  return made;
}

const calibration::ChannelRange* SnapshotBuilder::domain_of(const std::string& symbol) const {
  for (const auto& range : model_.domain)
    if (range.channel.symbol == symbol) return &range;
  return nullptr;
}

calibration::ChannelRange SnapshotBuilder::range_of(const Channel& channel) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  if (const auto* range = domain_of(channel.symbol)) return *range;
  return {channel, -kFar, kFar};
}

Result<void> SnapshotBuilder::add_geometry() {
  if (gives_ == Gives::coordinates)
    return not_servable(reasons::kNotAMotorModel,
                        "the model is a robot's geometry: it predicts no motion of another");
  DRIFTWISE_TRY(law_, make_geometry_law(model_));
  if (law_->absolute()) DRIFTWISE_RETURN_IF_ERROR(check_geometry_alone(model_));
  for (const Variable variable : law_->needs())
    DRIFTWISE_RETURN_IF_ERROR(add_fast_input(channel_of(variable), range_of(channel_of(variable))));
  for (const auto& channel : law_->temperatures()) slow_.add_channel(channel);
  for (std::size_t i = 0; i < law_->motors().size(); ++i) {
    const Channel& motor = law_->motors()[i];
    const auto fitted =
        std::ranges::find(model_.outputs, motor, &calibration::OutputModel::channel);
    if (fitted != model_.outputs.end()) {
      DRIFTWISE_RETURN_IF_ERROR(add_output(*fitted));
    } else {
      outputs_.emplace_back().channel = motor;
    }
    const auto [low, high] = law_->limits(i);
    if (low > -std::numeric_limits<double>::infinity() ||
        high < std::numeric_limits<double>::infinity())
      outputs_.back().travel_mm = {low, high};
  }
  standing_.assign(outputs_.size(), kMissing);
  anchored_ = law_->absolute();
  return {};
}

void SnapshotBuilder::observe_middle(CellTime at) {
  std::vector<double> middles;
  for (const auto& channel : slow_.channels()) {
    const auto* range = domain_of(channel.symbol);
    middles.push_back(range == nullptr ? kMissing : 0.5 * (range->min + range->max));
  }
  slow_.take(middles, at);
}

std::vector<std::string> SnapshotBuilder::slow_channels() const {
  std::vector<std::string> names;
  for (const auto& read : slow_.read_as()) names.push_back(read.name);
  return names;
}

std::vector<std::string> SnapshotBuilder::observed_channels() const {
  auto names = slow_channels();
  if (law_)
    for (const auto& output : outputs_) names.push_back(output.channel.name());
  return names;
}

void SnapshotBuilder::observe_motors(std::span<const ChannelValue> values) {
  for (std::size_t i = 0; i < outputs_.size(); ++i)
    for (const auto& value : values)
      if (!is_missing(value.value) && value.channel == outputs_[i].channel.name())
        standing_[i] = value.value;
}

PresentGeometry SnapshotBuilder::present_geometry(const Conditions& conditions) const {
  PresentGeometry present{law_, {}, {}, standing_, !datum_.empty(), parameter_errors_};
  for (const auto& channel : law_->temperatures()) {
    const std::size_t at = *slow_.find(channel.symbol);
    present.temperatures.push_back(conditions.channels[at]);
    present.u_temperatures.push_back(
        std::hypot(conditions.u_systematic[at], conditions.u_independent[at]));
  }
  return present;
}

Result<void> SnapshotBuilder::add_output(const calibration::OutputModel& from) {
  const bool is_angle_output = is_angle(from.channel.unit);
  if (gives_ == Gives::motors
          ? !is_motor_symbol(from.channel.symbol) || !is_length(from.channel.unit)
          : !is_pose_symbol(from.channel.symbol) ||
                !(is_length(from.channel.unit) || is_angle_output))
    return not_servable(
        reasons::kNotAMotorModel,
        "the model gives " + from.channel.name() +
            (gives_ == Gives::coordinates
                 ? ", expected coordinates of the pose such as x_mm: it predicts no motion"
             : robot_of(from.channel.symbol).empty()
                 ? ", expected motor coordinates such as q1_mm: it cannot serve targets"
                 : ", a coordinate of one robot of several: it serves within a serving plan "
                   "(driftwise plan add)"));
  Output output;
  output.channel = {from.channel.symbol, is_angle_output ? "arcsec" : "mm"};
  output.mm_per_unit = is_angle_output ? summary_unit(from.channel.unit).factor
                                       : mm_from_nm(summary_unit(from.channel.unit).factor);
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < from.terms.size(); ++k) {
    if (effects::datum_of(from.terms[k])) continue;  // the constants of other data: never served
    DRIFTWISE_TRY(auto term, split(from.terms[k]));
    term.coefficient = from.coefficients[static_cast<Eigen::Index>(k)];
    output.terms.push_back(std::move(term));
    kept.push_back(static_cast<Eigen::Index>(k));
  }
  output.covariance = uncertainty_of(from)(kept, kept);
  if (from.covariance_root.size() > 0) output.root = from.covariance_root(kept, Eigen::all);
  output.root_beside_zero = output.root;
  outputs_.push_back(std::move(output));
  return {};
}

Result<SnapshotBuilder::Term> SnapshotBuilder::split(const effects::Term& term) {
  const auto in_term = [&](const std::string& what) {
    return "term " + effects::notation(term) + " " + what;
  };
  Term out;
  Exponents exponents{};
  for (const auto& symbol : effects::symbols_of(term)) {
    const auto* range = domain_of(symbol);
    if (!range)
      return not_servable(
          reasons::kNoDomain,
          in_term("reads " + symbol +
                  ", and the model does not say the range it was fitted in: fit it again"));
    if (const auto variable = variable_from(symbol)) {
      DRIFTWISE_RETURN_IF_ERROR(add_fast_input(channel_of(*variable), *range));
    } else {
      slow_.add_channel(range->channel);
    }
  }
  for (const auto& factor : term.factors) {
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      if (is_motor_symbol(power->symbol))
        return not_servable(reasons::kTermNotServable,
                            in_term("reads the motor coordinate " + power->symbol +
                                    ", which is what a target asks for"));
      if (const auto variable = variable_from(power->symbol))
        exponents[static_cast<std::size_t>(*variable)] += power->exponent;
      else
        out.slow.powers.push_back({*slow_.find(power->symbol), power->exponent});
      continue;
    }
    const auto& call = std::get<effects::Call>(factor);
    if (const auto* kind = effects::find_effect(call.effect); kind && kind->in_data_time)
      return not_servable(reasons::kTermNotServable,
                          in_term("follows the clock of the data it was fitted to, which says "
                                  "nothing about a target asked for later"));
    for (const auto& symbol : call.symbols)
      if (variable_from(symbol))
        return not_servable(reasons::kTermNotServable,
                            in_term("follows " + symbol + " over time: a wanted pose has no past"));
    DRIFTWISE_TRY(const auto index, slow_.add_call(call));
    out.slow.calls.push_back(index);
  }
  out.basis = basis_.index_of(exponents);
  return out;
}

Result<void> SnapshotBuilder::add_fast_input(const Channel& channel,
                                             const calibration::ChannelRange& range) {
  const Variable variable = *variable_from(channel.symbol);
  if (std::ranges::find(fast_inputs_, variable, &FastInput::variable) != fast_inputs_.end())
    return {};
  const auto to_column = calibration::to_model_unit(channel, range.channel);
  if (!to_column || to_column->offset != 0)
    return not_servable(reasons::kTermNotServable, "the model has " + range.channel.name() +
                                                       ", expected the unit of " + channel.name() +
                                                       " or one of its kind");
  const double column_per_unit = to_column->factor / to_column->divisor;
  column_per_unit_[static_cast<std::size_t>(variable)] = column_per_unit;
  const auto wide = widened(range);
  fast_inputs_.push_back({variable, wide.min / column_per_unit, wide.max / column_per_unit});
  return {};
}

Snapshot SnapshotBuilder::build(CellTime now) const {
  Snapshot snapshot;
  snapshot.model = id_;
  snapshot.built_at = now;
  // Twice the period: who asks just before a rebuild still has a whole period to use the answer.
  snapshot.valid_until = now + nanoseconds_from_s(2 * rules_.rebuild_period_s);
  snapshot.products = basis_.products();
  snapshot.needed = basis_.needed();
  if (law_)
    for (const Variable variable : law_->needs()) snapshot.needed |= bit(variable);
  snapshot.column_per_unit = column_per_unit_;
  snapshot.column_shift = column_shift_;
  snapshot.anchored = anchored_;
  snapshot.refuse_stale = rules_.refuse_stale;
  snapshot.refuse_outside_domain = rules_.refuse_outside_domain;
  const Conditions conditions = look_at_inputs(now, snapshot);
  for (std::size_t i = 0; i < zero_excess_.size(); ++i) {
    if (zero_excess_[i] > 0) snapshot.zero_outside |= std::uint64_t{1} << i;
    snapshot.zero_excess = std::max(snapshot.zero_excess, zero_excess_[i]);
  }
  snapshot.refuse_outside_limits = rules_.refuse_outside_limits;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    snapshot.outputs.push_back(fold(i, conditions));
    if (!outputs_[i].travel_mm) {
      snapshot.unlimited |= 1u << i;
      continue;
    }
    snapshot.outputs.back().min_mm = outputs_[i].travel_mm->first;
    snapshot.outputs.back().max_mm = outputs_[i].travel_mm->second;
  }
  if (!law_) return snapshot;
  snapshot.geometry = present_geometry(conditions);
  snapshot.unjudged = model_.geometry->covariance.size() == 0;
  for (std::size_t i = 0; i < outputs_.size(); ++i)
    if (const auto* range = domain_of(outputs_[i].channel.symbol))
      snapshot.inputs.push_back({.channel = outputs_[i].channel,
                                 .variable = {},
                                 .min = widened(*range).min,
                                 .max = widened(*range).max,
                                 .at = {},
                                 .output = i});
  return snapshot;
}

// Temperature at which the drift of an arm's joints is 0, in the channel's unit.
double SnapshotBuilder::drift_reference(const Channel& channel) const {
  for (const auto& link : model_.geometry->robot.links)
    if (link.errors.drift_channel == channel)
      return link.errors.drift_from_degC + (channel.unit == "K" ? 273.15 : 0);
  return 0;
}

// Fills inputs, their bits and valid_until. A channel that was never read is replaced by the middle
// of its fitted range with the standard uncertainty of a rectangular distribution over it
// (GUM 4.3.7); a stale one keeps its value and gets that uncertainty on top.
SnapshotBuilder::Conditions SnapshotBuilder::look_at_inputs(CellTime now,
                                                            Snapshot& snapshot) const {
  Conditions conditions;
  for (const auto& fast : fast_inputs_)
    snapshot.inputs.push_back({.channel = channel_of(fast.variable),
                               .variable = fast.variable,
                               .min = fast.min,
                               .max = fast.max,
                               .at = {}});
  const Nanoseconds max_age = nanoseconds_from_s(rules_.max_age_s);
  for (std::size_t j = 0; j < slow_inputs_.size(); ++j) {
    const auto& range = slow_inputs_[j];
    const auto& latest = slow_.latest()[j];
    const std::uint64_t mark = std::uint64_t{1} << snapshot.inputs.size();
    const double u_range = (range.max - range.min) / std::sqrt(12.0);
    const bool missing = is_missing(latest.value);
    const bool stale = !missing && now - latest.at > max_age;
    // An imported geometry has no fitted range: its drifts count from where they are 0.
    const bool ranged = std::isfinite(u_range);
    const double middle =
        ranged ? 0.5 * (range.min + range.max) : drift_reference(slow_.channels()[j]);
    const double value = missing ? middle : latest.value;
    const double u_independent = ranged && (missing || stale) ? u_range : 0.0;
    if (missing) snapshot.missing |= mark;
    if (stale) snapshot.stale |= mark;
    if (!missing && !stale)
      snapshot.valid_until = std::min(snapshot.valid_until, latest.at + max_age);
    if (const double excess = excess_of(range.min, range.max, value); excess > 0) {
      snapshot.outside |= mark;
      snapshot.slow_excess = std::max(snapshot.slow_excess, excess);
    }
    snapshot.inputs.push_back({.channel = slow_.channels()[j],
                               .variable = {},
                               .min = range.min,
                               .max = range.max,
                               .value = value,
                               .u = std::hypot(range.u, u_independent),
                               .at = latest.at});
    conditions.channels.push_back(value);
    conditions.u_systematic.push_back(range.u);
    conditions.u_independent.push_back(u_independent);
    conditions.middle.push_back(middle);
  }
  conditions.calls = slow_.call_values(conditions.channels);
  conditions.call_slopes = slow_.settled_slopes(conditions.channels);
  conditions.call_shifts = slow_.call_shifts();
  conditions.middle_calls = slow_.settled_calls(conditions.middle);
  return conditions;
}

}  // namespace driftwise::compensation
