#include "server/diagnosis/rows/jump_witnesses.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kPlacebos = 19;  // an ordinary jump is the best of twenty in 5 %
constexpr double kEvidence = 25;       // 2 ln L of the outputs with the mended readings
constexpr double kOverLag = 6;         // 2 ln L: odds of 20 to 1 against a part that warms slowly
constexpr std::size_t kLags = 10;      // time constants that are tried

// Product of two chances that are independent where nothing is wrong: how often it is as small.
double of_both(double a, double b) {
  const double product = a * b;
  return product > 0 ? std::min(1.0, product * (1 - std::log(product))) : 0;
}

// Evidence of the outputs for mended readings: a ratio of likelihoods has the mean 1 where the
// readings are right, so that it is as large with a chance of 1 over itself at most.
double by_outputs(double gain) { return std::exp(-std::max(gain, 0.0) / 2); }

// Loss in 2 ln L by a column of no effect that chance exceeds once in a hundred: chi squared with a
// degree of freedom for each output (Wilson and Hilferty 1931). The jump in a sensor is such a
// column; outputs that lose more without it follow what the sensor read.
double lost_by_chance(std::size_t outputs) {
  constexpr double kQuantile = 2.326;
  const auto n = static_cast<double>(outputs);
  return n * std::pow(1 - 2 / (9 * n) + kQuantile * std::sqrt(2 / (9 * n)), 3);
}

// True: the outputs are described better with the jump in the readings than with the same jump at
// any of other rows, spread over the data. Without it they may do worse by much and not follow: the
// jump makes a column that tells this thermometer from the others, and slow noise takes any such
// column.
bool outputs_follow(Dataset& dataset, std::vector<double>& mended, double size, std::size_t row,
                    double as_read, const OutputsLikelihood& two_ln_likelihood) {
  const std::vector<double> values = mended;
  bool follow = true;
  for (std::size_t k = 0; follow && k < kPlacebos; ++k) {
    const std::size_t elsewhere = (k + 1) * values.size() / (kPlacebos + 1);
    if (std::max(elsewhere, row) - std::min(elsewhere, row) < 2 * kWindow) continue;
    for (std::size_t i = elsewhere; i < values.size(); ++i) mended[i] = values[i] + size;
    follow = two_ln_likelihood(dataset, {}) < as_read;
    mended = values;
  }
  return follow;
}

// True: the outputs step at this row by something else than the reading foretells. They are then no
// witness of the jump: what they lose without it is that other step's.
bool outputs_step_too(const Dataset& dataset, std::size_t outputs, std::size_t row,
                      const OutputsLikelihood& two_ln_likelihood) {
  // Without the rows about it: the temperatures that the baseline reads are smoothed there.
  const auto beyond = [&](std::size_t at) {
    return two_ln_likelihood(dataset, {at, kWindow, true}) -
           two_ln_likelihood(dataset, {at, kWindow, false});
  };
  const double here = beyond(row);
  if (here <= lost_by_chance(outputs)) return false;
  for (std::size_t k = 0; k < kPlacebos; ++k) {
    const std::size_t elsewhere = (k + 1) * dataset.rows / (kPlacebos + 1);
    if (std::max(elsewhere, row) - std::min(elsewhere, row) < 2 * kWindow) continue;
    if (beyond(elsewhere) >= here) return false;
  }
  return true;
}

// The best 2 ln L with a part that follows the reading with a lag: what a body does that a
// thermometer on its skin is ahead of.
double best_with_lag(Dataset& dataset, std::vector<double>& values,
                     const OutputsLikelihood& two_ln_likelihood) {
  const std::vector<double> as_read = values;
  const auto at = [&](std::size_t i) {
    return dataset.time_s.empty() ? static_cast<double>(i) : dataset.time_s[i];
  };
  const std::size_t last = values.size() - 1;
  const double length = at(last) - at(0), step = length / static_cast<double>(last);
  double best = -INFINITY;
  for (std::size_t k = 0; k < kLags && length > 0; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(kLags - 1);
    const double tau = step * std::pow(length / step, share);
    double part = kMissing, before = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(as_read[i])) continue;
      if (!std::isfinite(part)) part = as_read[i];
      part += (as_read[i] - part) * (1 - std::exp(-std::max(at(i) - before, 0.0) / tau));
      before = at(i);
      values[i] = part;
    }
    best = std::max(best, two_ln_likelihood(dataset, {}));
    values = as_read;
  }
  return best;
}

// Of a knock of the robot at this row that an ordinary change of a thermometer imitates. The steps
// of the outputs are a point at a distance of sqrt(free) from none, in standard errors; the change
// times the thermometer's coefficients is a point that lies anywhere within that distance, and has
// come as near to it as sqrt(free - gain): chance (near / far)^outputs.
double chance_of_knock(double p_at_row, double free, double gain, std::size_t outputs) {
  const auto count = static_cast<double>(outputs);
  const double near = std::max(free - gain, count);
  return p_at_row * std::min(1.0, std::pow(near / std::max(free, near), count / 2));
}

}  // namespace

std::optional<FaultySensor> JumpWitnesses::look_at(std::size_t sensor, std::size_t row) {
  std::vector<std::size_t> together;
  for (std::size_t other = 0; other < sensors_.size(); ++other)
    if (sensors_[other].jumps_at(row)) together.push_back(other);
  if (!as_read_) as_read_ = two_ln_likelihood_(dataset_, {});
  const double as_read = *as_read_;
  if (sensors_[sensor].jumps_at(row))
    for (const std::size_t other : together)
      if (other != sensor && takes_the_place_of(sensor, other, row))
        return exchange(sensor, other, row, as_read);
  if (together.size() > 1 && 2 * together.size() > sensors_.size()) return {};  // the room did
  return jump(sensor, row, as_read);
}

std::vector<std::size_t> JumpWitnesses::rows_from(std::size_t row) const {
  std::vector<std::size_t> rows;
  for (std::size_t i = row; i < dataset_.rows; ++i) rows.push_back(i);
  return rows;
}

bool JumpWitnesses::takes_the_place_of(std::size_t sensor, std::size_t other, std::size_t row) {
  const auto &own = values_of(sensor), &theirs = values_of(other);
  const double apart = theirs[row - 1] - own[row - 1];
  return std::abs(level_change(own, row) - apart) < 0.1 * std::abs(apart) &&
         std::abs(level_change(theirs, row) + apart) < 0.1 * std::abs(apart);
}

// Readings of two sensors from this row on, put back where they belong.
std::optional<FaultySensor> JumpWitnesses::exchange(std::size_t sensor, std::size_t other,
                                                    std::size_t row, double as_read) {
  auto &own = values_of(sensor), &theirs = values_of(other);
  const auto from = static_cast<std::ptrdiff_t>(row);
  const auto swap = [&] { std::swap_ranges(own.begin() + from, own.end(), theirs.begin() + from); };
  swap();
  const double gain = two_ln_likelihood_(dataset_, {}) - as_read;
  if (gain < kEvidence) {
    swap();
    return {};
  }
  as_read_.reset();
  std::erase(sensors_[other].jumps, row);
  return FaultySensor{SensorFault::swapped,
                      sensors_[sensor].column->channel.symbol,
                      sensors_[other].column->channel.symbol,
                      rows_from(row),
                      level_change(own, row),
                      true,
                      by_outputs(gain)};
}

std::optional<FaultySensor> JumpWitnesses::jump(std::size_t sensor, std::size_t row,
                                                double as_read) {
  auto& values = values_of(sensor);
  const auto& beyond = beyond_[sensor];
  const std::vector<double> readings = values;
  double size = level_change(beyond, row);
  const bool by_readings_alone =
      sensors_[sensor].jumps_at(row) && !goes_on_as_ramp(beyond, row, size);
  const auto without = [&](double one) {
    for (std::size_t i = row; i < values.size(); ++i) values[i] = readings[i] - one;
  };
  const bool stands = stands_alone(sensors_, sensor, row);
  const bool others_change = !stands && sensors_.size() > 1;
  // A free level can do all that a mended reading does, but for what smoothing makes of the jump.
  // It starts from a baseline that the jump has spoilt, so that of a jump which the readings show
  // it is not asked.
  const double free = two_ln_likelihood_(dataset_, {row, 0, true}) - as_read;
  if (!by_readings_alone && (free < kEvidence || others_change)) return {};  // or the room moved
  double gain = -INFINITY;
  for (const double one : {size, own_change(readings, row), own_change(beyond, row)}) {
    if (by_readings_alone && gain > -INFINITY) break;
    without(one);
    const double with_it = two_ln_likelihood_(dataset_, {}) - as_read;
    if (with_it > gain) gain = with_it, size = one;
  }
  values = readings;
  const bool mended = gain >= kEvidence;
  if (!mended && !by_readings_alone) return {};
  const double resolution = resolution_of(readings);
  const double at_row =
      std::max(chance_at_row(readings, row, resolution), chance_at_row(beyond, row, resolution));
  // The size is known to a usual change: a part of the outputs' step is left for it.
  const double unsure = std::max(usual_change(beyond), resolution) / size;
  const bool stepped_otherwise =
      free - gain > lost_by_chance(outputs_) * (1 + free * unsure * unsure) ||
      chance_of_knock(at_row, free, gain, outputs_) * static_cast<double>(sensors_.size()) > alpha_;
  if (!by_readings_alone && stepped_otherwise) return {};
  FaultySensor fault{SensorFault::jumped,
                     sensors_[sensor].column->channel.symbol,
                     "",
                     rows_from(row),
                     size,
                     mended,
                     of_both(chance_of_as_many(at_row, 1, values.size()), by_outputs(gain)),
                     mended || stands};
  fault.others_change = others_change;
  const auto is_real = [&]() -> std::optional<FaultySensor> {
    values = readings;
    if (!by_readings_alone) return {};
    fault.is_followed = true;
    fault.mended = fault.named = false;
    return fault;
  };
  const double slowly = best_with_lag(dataset_, values, two_ln_likelihood_) - as_read;
  without(size);
  if (slowly >= std::max({kEvidence, gain - kOverLag, free - kOverLag})) {
    if (!by_readings_alone) return is_real();
    // A lag of hours takes any jump out, and then has as much with the mended readings.
    const double mended_slowly = best_with_lag(dataset_, values, two_ln_likelihood_) - as_read;
    if (slowly >= mended_slowly + kOverLag) return is_real();
  }
  const bool followed = gain < -lost_by_chance(outputs_) &&
                        outputs_follow(dataset_, values, size, row, as_read, two_ln_likelihood_);
  if (!mended) values = readings;
  if (followed && !outputs_step_too(dataset_, outputs_, row, two_ln_likelihood_)) return is_real();
  if (mended) as_read_.reset();
  return fault;
}

}  // namespace driftwise::diagnosis
