#include "server/compensation/slow_state.h"

#include <algorithm>

#include "server/core/try.h"
#include "server/effects/time_constant.h"

namespace driftwise::compensation {

std::size_t SlowState::add_channel(const Channel& channel) {
  if (const auto known = find(channel.symbol)) return *known;
  channels_.push_back(channel);
  read_as_.push_back({channel.name(), {}});
  latest_.emplace_back();
  before_first_.push_back(0);
  return channels_.size() - 1;
}

std::optional<std::size_t> SlowState::find(const std::string& symbol) const {
  const auto found = std::ranges::find(channels_, symbol, &Channel::symbol);
  if (found == channels_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - channels_.begin());
}

Result<std::size_t> SlowState::add_call(const effects::Call& call) {
  for (std::size_t i = 0; i < calls_.size(); ++i)
    if (calls_[i].call == call) return i;
  DRIFTWISE_TRY(auto evaluator,
                effects::TermEvaluator::create({effects::Term{{call}}}, call.symbols));
  Tracker tracker{call, std::move(evaluator), {}};
  for (const auto& symbol : call.symbols) tracker.channels.push_back(find(symbol).value());
  calls_.push_back(std::move(tracker));
  return calls_.size() - 1;
}

void SlowState::observe(std::span<const ChannelValue> values, CellTime at) {
  std::vector<double> by_channel(channels_.size(), kMissing);
  for (const auto& [name, value] : values) {
    const auto found = std::ranges::find(read_as_, name, &ReadAs::name);
    if (found != read_as_.end() && !is_missing(value))
      by_channel[static_cast<std::size_t>(found - read_as_.begin())] = found->to_unit(value);
  }
  take(by_channel, at);
}

void SlowState::take(std::span<const double> by_channel, CellTime at) {
  std::vector<bool> fresh(channels_.size(), false);
  for (std::size_t i = 0; i < by_channel.size(); ++i) {
    if (is_missing(by_channel[i])) continue;
    if (at < latest_[i].at) continue;  // a late reading must not turn time back
    latest_[i] = {by_channel[i], at};
    fresh[i] = true;
  }
  for (auto& tracker : calls_) {
    if (!std::ranges::any_of(tracker.channels, [&](std::size_t i) { return fresh[i]; })) continue;
    std::vector<double> inputs;
    for (const std::size_t i : tracker.channels) inputs.push_back(latest_[i].value);
    if (!origin_) origin_ = at;
    const double time_s = seconds_from(at - *origin_);
    const bool first = is_missing(tracker.output);
    double output = kMissing;
    tracker.evaluator.step(time_s, inputs, std::span(&output, 1));
    if (is_missing(output)) continue;
    tracker.output = output;
    if (first) begin_twin(tracker, time_s, inputs);
    if (tracker.twin) tracker.twin->step(time_s, inputs, std::span(&tracker.twin_output, 1));
  }
}

void SlowState::begin_twin(Tracker& tracker, double time_s, std::span<const double> inputs) const {
  constexpr double kBefore_s = 1e-3;  // short against every time constant
  std::vector<double> other(inputs.begin(), inputs.end());
  bool differs = false;
  for (std::size_t i = 0; i < other.size(); ++i) {
    other[i] += before_first_[tracker.channels[i]];
    differs = differs || other[i] != inputs[i];
  }
  if (!differs) return;
  auto twin = effects::TermEvaluator::create({effects::Term{{tracker.call}}}, tracker.call.symbols);
  if (!twin) return;
  twin->step(time_s - kBefore_s, other, std::span(&tracker.twin_output, 1));
  tracker.twin = std::move(*twin);
}

std::vector<double> SlowState::call_shifts() const {
  std::vector<double> out;
  for (const auto& tracker : calls_) {
    const double shift = tracker.twin ? tracker.twin_output - tracker.output : 0;
    out.push_back(is_missing(shift) ? 0 : shift);
  }
  return out;
}

double SlowState::longest_tau_s() const {
  double longest = 0;
  for (const auto& tracker : calls_) longest = std::max(longest, effects::tau_s(tracker.call));
  return longest;
}

double SlowState::settled(const Tracker& tracker, std::span<const double> channels) {
  auto fresh =
      effects::TermEvaluator::create({effects::Term{{tracker.call}}}, tracker.call.symbols);
  double value = kMissing;
  std::vector<double> inputs;
  for (const std::size_t i : tracker.channels) inputs.push_back(channels[i]);
  if (fresh) fresh->step(0.0, inputs, std::span(&value, 1));
  return value;
}

std::vector<double> SlowState::settled_calls(std::span<const double> channels) const {
  std::vector<double> out;
  for (const auto& tracker : calls_) out.push_back(settled(tracker, channels));
  return out;
}

CallSlopes SlowState::settled_slopes(std::span<const double> channels) const {
  constexpr double kStep = 1e-3;  // K or N; exact for what is linear or quadratic in the channel
  CallSlopes out(calls_.size(), std::vector<double>(channels_.size(), 0.0));
  std::vector<double> moved(channels.begin(), channels.end());
  for (std::size_t i = 0; i < calls_.size(); ++i)
    for (const std::size_t j : calls_[i].channels) {
      moved[j] = channels[j] + kStep;
      const double above = settled(calls_[i], moved);
      moved[j] = channels[j] - kStep;
      const double slope = (above - settled(calls_[i], moved)) / (2 * kStep);
      moved[j] = channels[j];
      if (!is_missing(slope)) out[i][j] = slope;
    }
  return out;
}

std::vector<double> SlowState::call_values(std::span<const double> channels_instead) const {
  std::vector<double> out;
  for (const auto& tracker : calls_) {
    double value = tracker.output;
    if (is_missing(value) && !channels_instead.empty()) value = settled(tracker, channels_instead);
    out.push_back(value);
  }
  return out;
}

double value_of(const SlowProduct& product, std::span<const double> channels,
                std::span<const double> calls) {
  double value = 1.0;
  for (const auto& factor : product.powers)
    value *= effects::power(channels[factor.index], factor.exponent);
  for (const std::size_t call : product.calls) value *= calls[call];
  return value;
}

double derivative_by_call(const SlowProduct& product, std::size_t call,
                          std::span<const double> channels, std::span<const double> calls) {
  double powers = 1, of_calls = 1, slope = 0;
  for (const auto& factor : product.powers)
    powers *= effects::power(channels[factor.index], factor.exponent);
  for (const std::size_t one : product.calls) {
    slope = slope * calls[one] + (one == call ? of_calls : 0);
    of_calls *= calls[one];
  }
  return powers * slope;
}

double derivative_of(const SlowProduct& product, std::size_t channel,
                     std::span<const double> channels, std::span<const double> calls,
                     const CallSlopes& slopes) {
  double of_calls = 1, powers = 1, by_power = 0, by_calls = 0;
  for (const std::size_t call : product.calls) {
    by_calls = by_calls * calls[call] + of_calls * slopes[call][channel];
    of_calls *= calls[call];
  }
  for (const auto& factor : product.powers) {
    const double value = effects::power(channels[factor.index], factor.exponent);
    double slope = 0;
    if (factor.index == channel)
      slope = factor.exponent *
              (factor.exponent > 1 ? effects::power(channels[channel], factor.exponent - 1) : 1);
    by_power = by_power * value + powers * slope;
    powers *= value;
  }
  return by_power * of_calls + powers * by_calls;
}

}  // namespace driftwise::compensation
