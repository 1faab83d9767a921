// Carrying a model to the datum that it serves in.
//
// A datum zeroes the instruments, not the robot: when the robot has warmed since the data were
// taken, pose 0 of the new datum is another place in theirs. Where the geometry is curved, or terms
// are products of pose and temperature, f(pose) - f(0) is not f(pose + p0) - f(p0): for the
// Micro-Nano's arms of 70 mm and a p0 of 5 um they differ by 70 nm per mm of pose. p0 is where the
// model itself has the motor coordinates that were read back at the zero.

#include <Eigen/Core>

#include "server/calibration/pose_of_zero.h"
#include "server/compensation/snapshot_builder.h"
#include "server/core/reasons.h"

namespace driftwise::compensation {

std::array<double, kVariables> SnapshotBuilder::pose_at_zero(
    std::array<double, kVariables> pose, const std::vector<double>& channels,
    const std::vector<double>& calls, const std::vector<double>& q_mm) const {
  std::vector<std::size_t> axes;
  std::vector<double> range;  // column unit
  for (const auto& fast : fast_inputs_)
    if (is_length(channel_of(fast.variable).unit)) {
      axes.push_back(static_cast<std::size_t>(fast.variable));
      range.push_back((fast.max - fast.min) * column_per_unit_[axes.back()]);
    }
  std::array<double, kVariables> shift{};
  // A geometry counts from its own pose 0, which its zero is.
  if (axes.size() != outputs_.size() || law_) return shift;
  std::vector<double> basis;
  const auto left = [&](const Eigen::VectorXd& by) {
    auto at = pose;
    for (std::size_t k = 0; k < axes.size(); ++k) at[axes[k]] += by[static_cast<Eigen::Index>(k)];
    basis_.evaluate(at, basis);
    Eigen::VectorXd rest(by.size());
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      double& one = rest[static_cast<Eigen::Index>(i)];
      one = q_mm[i] / outputs_[i].mm_per_unit;
      for (const auto& term : outputs_[i].terms)
        one -= term.coefficient * basis[term.basis] * value_of(term.slow, channels, calls);
    }
    return rest;
  };
  const Eigen::VectorXd found = calibration::pose_of_zero(range, left);
  for (std::size_t k = 0; k < axes.size(); ++k)
    shift[axes[k]] = found[static_cast<Eigen::Index>(k)];
  return shift;
}

std::vector<double> SnapshotBuilder::excess_at_zero(double force,
                                                    const std::vector<double>& channels) const {
  std::vector<double> excess;
  for (const auto& fast : fast_inputs_)  // a pose counts from the zero: 0 there
    excess.push_back(excess_of(fast.min, fast.max, fast.variable == Variable::force ? force : 0.0));
  for (std::size_t j = 0; j < channels.size(); ++j)
    excess.push_back(excess_of(slow_inputs_[j].min, slow_inputs_[j].max, channels[j]));
  return excess;
}

Result<void> SnapshotBuilder::anchor(std::span<const ChannelValue> values) {
  if (law_ && law_->absolute()) return {};
  forget_datum();
  const auto find = [&](const std::string& name) {
    for (const auto& value : values)
      if (value.channel == name && !is_missing(value.value)) return std::optional(value.value);
    return std::optional<double>();
  };
  const auto incomplete = [](const std::string& name) {
    return fail(
        ErrorCode::failed_precondition, reasons::kIncompleteDatum,
        "the zero of this datum has no " + name +
            ", which the model needs to be carried over to it: zero again with every sensor alive");
  };
  std::vector<double> channels;
  for (const auto& read : slow_.read_as()) {
    const auto value = find(read.name);
    if (!value) return incomplete(read.name);
    channels.push_back(read.to_unit(*value));
  }
  const auto calls = slow_.call_values();
  for (std::size_t i = 0; i < calls.size(); ++i)
    if (is_missing(calls[i]))
      return fail(ErrorCode::failed_precondition, reasons::kIncompleteDatum,
                  "the recorded readings of " +
                      slow_.channels()[slow_.channels_of_call(i).front()].name() +
                      " begin after the zero of this datum, and the model needs those before it: "
                      "take the zero again");
  std::array<double, kVariables> pose{};  // zeroed here, so all 0 but the force
  double force_n = 0;
  if (basis_.needed() & bit(Variable::force)) {
    const auto force = find(channel_of(Variable::force).name());
    if (!force) return incomplete(channel_of(Variable::force).name());
    force_n = *force;
    pose[static_cast<std::size_t>(Variable::force)] =
        force_n * column_per_unit_[static_cast<std::size_t>(Variable::force)];
  }
  std::vector<double> q_mm;
  for (const auto& output : outputs_) {
    const auto q = gives_ == Gives::coordinates ? std::optional(0.0) : find(output.channel.name());
    if (!q) return incomplete(output.channel.name());
    q_mm.push_back(*q);
  }
  const auto shift = gives_ == Gives::coordinates ? std::array<double, kVariables>{}
                                                  : pose_at_zero(pose, channels, calls, q_mm);
  for (std::size_t v = 0; v < kVariables; ++v) pose[v] += shift[v];
  std::vector<double> basis;
  basis_.evaluate(pose, basis);

  const auto call_slopes = slow_.settled_slopes(channels);
  const auto call_shifts = slow_.call_shifts();
  std::vector<Datum> data;
  for (const auto& output : outputs_) {
    Datum datum;
    datum.q_mm = q_mm[data.size()];
    for (const auto& term : output.terms)
      datum.term_values.push_back(basis[term.basis] * value_of(term.slow, channels, calls));
    for (std::size_t j = 0; j < channels.size(); ++j) {
      auto& slopes = datum.term_slopes.emplace_back();
      for (const auto& term : output.terms)
        slopes.push_back(basis[term.basis] *
                         derivative_of(term.slow, j, channels, calls, call_slopes));
    }
    for (std::size_t i = 0; i < call_shifts.size(); ++i) {
      auto& shifts = datum.term_shifts.emplace_back();
      for (const auto& term : output.terms)
        shifts.push_back(basis[term.basis] * call_shifts[i] *
                         derivative_by_call(term.slow, i, channels, calls));
    }
    data.push_back(std::move(datum));
  }
  datum_ = std::move(data);
  zero_excess_ = excess_at_zero(force_n, channels);
  column_shift_ = shift;
  anchored_ = true;
  return {};
}

void SnapshotBuilder::keep_anchor_of(const SnapshotBuilder& other) {
  datum_ = other.datum_;
  zero_excess_ = other.zero_excess_;
  column_shift_ = other.column_shift_;
  anchored_ = other.anchored_;
}

void SnapshotBuilder::keep_model_datum() {
  forget_datum();
  anchored_ = true;
}

void SnapshotBuilder::forget_datum() {
  datum_.clear();
  zero_excess_.clear();
  column_shift_ = {};
  anchored_ = false;
}

}  // namespace driftwise::compensation
