#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/core/data/reading.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/rows/screen.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kFarOffSensor = 12;  // robust standard deviations
constexpr double kSmallest_k = 0.02;  // no jump or spike below this is called a fault
constexpr std::size_t kFewestRows = 40, kWindow = 6, kNeighbours = 4;
constexpr std::size_t kPlacebos = 19;  // an ordinary jump is the best of twenty in 5 %
constexpr double kEvidence = 25;       // 2 ln L of the outputs with the mended readings
constexpr double kRamp = 0.25;         // of a jump, within a few rows after it
constexpr double kMoves = 4;           // of its usual change: a thermometer that follows an event
constexpr double kOverLag = 6;         // 2 ln L: odds of 20 to 1 against a part that warms slowly
constexpr std::size_t kLags = 10;      // time constants that are tried
constexpr std::size_t kMostSuspects = 16;  // per sensor, the largest

constexpr std::size_t kRowsPerSensor = 10;
constexpr std::size_t kSpan = 3;  // rows of a change that foretells: more than the readings' steps

// Product of two chances that are independent where nothing is wrong: how often it is as small.
double of_both(double a, double b) {
  const double product = a * b;
  return product > 0 ? std::min(1.0, product * (1 - std::log(product))) : 0;
}

// Evidence of the outputs for mended readings: a ratio of likelihoods has the mean 1 where the
// readings are right, so that it is as large with a chance of 1 over itself at most.
double by_outputs(double gain) { return std::exp(-std::max(gain, 0.0) / 2); }

struct Sensor {
  DatasetColumn* column = nullptr;
  double usual = 0;  // size of own_change() from row to row
  // Rows, ascending. jumps: so large that the readings alone show one. suspects: all others that
  // stand out, named on the outputs' evidence only.
  std::vector<std::size_t> jumps, suspects;
  bool jumps_at(std::size_t row) const { return std::ranges::find(jumps, row) != jumps.end(); }
};

// Beyond what the changes of the other thermometers foretell: a room that warms, or in which a door
// is opened, does so at several of them. As it is where there are no others or too few rows.
std::vector<double> beyond_the_others(const std::vector<Sensor>& sensors, std::size_t sensor) {
  const auto& own = sensors[sensor].column->values;
  const auto others = static_cast<Eigen::Index>(sensors.size()) - 1;
  std::vector<std::size_t> rows;
  for (std::size_t i = kSpan; i < own.size(); ++i)
    if (std::ranges::all_of(sensors, [i](const Sensor& one) {
          return std::isfinite(one.column->values[i]) &&
                 std::isfinite(one.column->values[i - kSpan]);
        }))
      rows.push_back(i);
  if (others < 1 || rows.size() < kRowsPerSensor * sensors.size()) return own;
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(rows.size()), others + 1);
  Eigen::VectorXd y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const std::size_t row = rows[static_cast<std::size_t>(i)];
    y[i] = own[row] - own[row - kSpan];
    for (std::size_t o = 0, k = 0; o < sensors.size(); ++o)
      if (const auto& v = sensors[o].column->values; o != sensor)
        x(i, static_cast<Eigen::Index>(k++)) = v[row] - v[row - kSpan];
  }
  // Twice, the second time without the changes that stand far off: a jump foretells nothing.
  Eigen::VectorXd b = x.colPivHouseholderQr().solve(y);
  const Eigen::VectorXd left = y - x * b;
  const double far = kMoves * robust_sd({left.data(), left.data() + left.size()});
  Eigen::VectorXd weight = (left.array().abs() <= far).cast<double>();
  if (far > 0) b = (weight.asDiagonal() * x).colPivHouseholderQr().solve(weight.cwiseProduct(y));
  std::vector<double> result = own;
  for (std::size_t i = 0; i < own.size(); ++i)
    for (std::size_t o = 0, k = 0; o < sensors.size(); ++o)
      if (o != sensor)
        result[i] -= b[static_cast<Eigen::Index>(k++)] * sensors[o].column->values[i];
  return result;
}

// What a column of no effect takes off 2 ln L by chance in one of a hundred: chi squared with a
// degree of freedom for each output (Wilson and Hilferty 1931). The jump in a sensor is such a
// column; outputs that lose more without it follow what the sensor read.
double lost_by_chance(std::size_t outputs) {
  constexpr double kQuantile = 2.326;
  const auto n = static_cast<double>(outputs);
  return n * std::pow(1 - 2 / (9 * n) + kQuantile * std::sqrt(2 / (9 * n)), 3);
}

std::vector<std::size_t> frozen_rows(const std::vector<double>& values) {
  std::vector<std::size_t> lengths;
  std::size_t longest = 0, begin = 0, second = 0;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i + 1;
    while (end < values.size() && values[end] == values[i]) ++end;
    if (end - i > longest) {
      second = longest;
      longest = end - i;
      begin = i;
    } else {
      second = std::max(second, end - i);
    }
    i = end;
  }
  std::vector<std::size_t> rows;
  if (longest < values.size() / 10 || longest < 10 * second || longest == values.size())
    return rows;
  for (std::size_t i = begin + 1; i < begin + longest; ++i) rows.push_back(i);
  return rows;
}

// Of a run of `length` equal readings anywhere, by how often the others repeat the one before.
double chance_frozen(const std::vector<double>& values, std::size_t length) {
  double same = 0, pairs = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (std::isfinite(values[i]) && std::isfinite(values[i - 1]))
      same += values[i] == values[i - 1] ? 1 : 0, pairs += 1;
  const double often = (same + 1) / (pairs + 2);
  return std::min(
      1.0, static_cast<double>(values.size()) * std::pow(often, static_cast<double>(length)));
}

// The smallest step between neighbouring values: that of a thermometer that reads in 0.01 K.
double resolution_of(const std::vector<double>& v) {
  double smallest = INFINITY;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::abs(v[i] - v[i - 1]) > 0) smallest = std::min(smallest, std::abs(v[i] - v[i - 1]));
  return std::isfinite(smallest) ? smallest : 0;
}

// p: of as many spikes as these.
std::vector<std::size_t> spiked_rows(const std::vector<double>& v, double& p) {
  std::vector<double> apart(v.size(), 0), across(v.size(), 0);
  for (std::size_t i = 1; i + 1 < v.size(); ++i) {
    apart[i] = v[i] - (v[i - 1] + v[i + 1]) / 2;
    across[i] = v[i + 1] - v[i - 1];
  }
  const double usual = std::max(robust_sd(apart), resolution_of(v));
  const double least = std::max(kFarOffSensor * usual, kSmallest_k);
  std::vector<std::size_t> rows;
  for (std::size_t i = 1; i + 1 < v.size(); ++i)
    if (std::abs(apart[i]) > least && std::abs(across[i]) < least / 2) rows.push_back(i);
  if (rows.empty()) return rows;
  double nearest = INFINITY;
  std::vector<double> others;
  for (std::size_t i = 1; i + 1 < v.size(); ++i) {
    const bool next_to =
        std::ranges::any_of(rows, [i](std::size_t row) { return i + 1 >= row && i <= row + 1; });
    if (std::ranges::find(rows, i) != rows.end()) nearest = std::min(nearest, std::abs(apart[i]));
    if (!next_to && std::isfinite(apart[i])) others.push_back(apart[i]);
  }
  const StudentLaw law = student_law(others, resolution_of(v));
  p = chance_of_as_many(law.beyond(nearest), rows.size(), v.size());
  return rows;
}

// The usual change from row to row about this row: a room that warms takes all rows along.
double trend_about(const std::vector<double>& v, std::size_t row) {
  std::vector<double> about;
  for (std::size_t i = row > kNeighbours ? row - kNeighbours : 1;
       i <= std::min(row + kNeighbours, v.size() - 1); ++i)
    if (i != row && std::isfinite(v[i]) && std::isfinite(v[i - 1]))
      about.push_back(v[i] - v[i - 1]);
  return about.empty() ? 0 : median(about);
}

// A change from the row before, beyond that trend.
double own_change(const std::vector<double>& v, std::size_t row) {
  return v[row] - v[row - 1] - trend_about(v, row);
}

// How far the level after a row stands off what the level before it and the trend foretell, each
// told by a few rows.
double level_change(const std::vector<double>& v, std::size_t row) {
  std::vector<double> before, after;
  for (std::size_t k = 0; k < kWindow; ++k) {
    if (row >= k + 1 && std::isfinite(v[row - 1 - k])) before.push_back(v[row - 1 - k]);
    if (row + k < v.size() && std::isfinite(v[row + k])) after.push_back(v[row + k]);
  }
  return median(after) - median(before) - static_cast<double>(kWindow) * trend_about(v, row);
}

// What warms goes on warming, or cools again: the level a little later is another one.
bool goes_on_as_ramp(const std::vector<double>& v, std::size_t row, double size) {
  std::vector<double> soon, later, before, long_before;
  for (std::size_t k = 0; k < kWindow; ++k) {
    if (row + k < v.size() && std::isfinite(v[row + k])) soon.push_back(v[row + k]);
    if (row + 3 * kWindow + k < v.size() && std::isfinite(v[row + 3 * kWindow + k]))
      later.push_back(v[row + 3 * kWindow + k]);
    if (row >= k + 1 && std::isfinite(v[row - 1 - k])) before.push_back(v[row - 1 - k]);
    if (row >= k + 1 + 3 * kWindow && std::isfinite(v[row - 1 - k - 3 * kWindow]))
      long_before.push_back(v[row - 1 - k - 3 * kWindow]);
  }
  if (soon.empty() || later.empty()) return false;
  const double drift =
      before.empty() || long_before.empty() ? 0 : median(before) - median(long_before);
  return std::abs(median(later) - median(soon) - drift) > kRamp * std::abs(size);
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

// True: there are others, and none changes at this row beyond its noise.
bool stands_alone(const std::vector<Sensor>& sensors, std::size_t sensor, std::size_t row) {
  for (std::size_t other = 0; other < sensors.size(); ++other) {
    if (other == sensor) continue;
    const auto& v = sensors[other].column->values;
    if (std::abs(own_change(v, row)) > kMoves * sensors[other].usual) return false;
  }
  return sensors.size() > 1;
}

// Of values in steps of 0.01 K the middle one is one step or none: the spread of those near it.
double spread_near(const std::vector<double>& values) {
  const double near = kMoves * robust_sd(values);
  double sum = 0, count = 0;
  for (const double value : values)
    if (std::abs(value) <= near) sum += value * value, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

double usual_change(const std::vector<double>& v) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::isfinite(v[i]) && std::isfinite(v[i - 1])) changes.push_back(own_change(v, i));
  return spread_near(changes);
}

// Of a change as large as that at this row, there: of the readings, and beyond what the other
// thermometers foretell.
double chance_at_row(const std::vector<double>& v, std::size_t row, double resolution) {
  std::vector<double> others;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::isfinite(v[i]) && std::isfinite(v[i - 1]) && i != row)
      others.push_back(own_change(v, i));
  return student_law(others, resolution).beyond(own_change(v, row));
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

// beyond: of beyond_the_others().
void find_jumps(Sensor& sensor, const std::vector<double>& beyond, const Dataset& dataset) {
  const auto& time_s = dataset.time_s;
  const auto begins = [](const std::vector<std::int64_t>& of, std::size_t i) {
    return !of.empty() && of[i] != of[i - 1];
  };
  const auto& v = sensor.column->values;
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  // Of values in steps of 0.01 K most do not change: that says nothing of a ramp of one step a row.
  const double resolution = resolution_of(v);
  sensor.usual = std::max(usual_change(v), resolution);
  const double step_s = median(steps);
  const double usual = std::max(usual_change(beyond), resolution);
  const auto stands_out = [&](std::size_t i, double least) {
    return std::abs(own_change(beyond, i)) > least && std::abs(own_change(v, i)) > least / 2 &&
           std::abs(level_change(beyond, i)) > 0.7 * least;
  };
  for (std::size_t i = kWindow; i + kWindow < v.size(); ++i) {
    if (!time_s.empty() && time_s[i] - time_s[i - 1] > 3 * step_s) continue;  // it had the time
    if (begins(dataset.run, i) || begins(dataset.datum, i)) continue;         // likewise
    if (stands_out(i, std::max(kFarOffSensor * usual, kSmallest_k)))
      sensor.jumps.push_back(i);
    else if (stands_out(i, kMoves * usual))
      sensor.suspects.push_back(i);
  }
  std::ranges::stable_sort(sensor.suspects, std::ranges::greater{},
                           [&](std::size_t i) { return std::abs(own_change(beyond, i)); });
  sensor.suspects.resize(std::min(sensor.suspects.size(), kMostSuspects));
  std::ranges::sort(sensor.suspects);
}

}  // namespace

double two_ln_likelihood(const Problem& problem, const FreeLevel& level) {
  const auto rows = static_cast<std::size_t>(problem.base_columns.rows());
  const std::size_t from = level.row > level.unread ? level.row - level.unread : 0;
  const std::size_t unread =
      level.unread == 0 ? 0 : std::min(level.row + level.unread, rows) - from;
  const auto base = problem.base_columns.cols(), free = static_cast<Eigen::Index>(unread);
  Eigen::MatrixXd columns(problem.base_columns.rows(), base + free + (level.is_free ? 1 : 0));
  columns.leftCols(base) = problem.base_columns;
  columns.rightCols(columns.cols() - base).setZero();
  for (Eigen::Index k = 0; k < free; ++k)
    columns(static_cast<Eigen::Index>(from) + k, base + k) = 1;
  if (level.is_free)
    columns.rightCols(1)
        .bottomRows(columns.rows() - static_cast<Eigen::Index>(level.row))
        .setOnes();
  double sum = 0;
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd left = rows_of(residuals(problem, output, columns), problem.learn);
    const Eigen::Index n = left.size();
    if (n < 3) continue;
    // Slow noise is no evidence of a jump: of each row what its neighbour before does not predict.
    const auto before = left.head(n - 1), after = left.tail(n - 1);
    const double share = std::clamp(before.dot(after) / before.squaredNorm(), 0.0, 0.99);
    sum -= static_cast<double>(n) * std::log((after - share * before).squaredNorm());
  }
  return sum;
}

std::vector<FaultySensor> mend_sensors(Dataset& dataset, std::size_t outputs, double alpha,
                                       const OutputsLikelihood& two_ln_likelihood) {
  std::vector<FaultySensor> found;
  if (dataset.rows < kFewestRows) return found;
  std::vector<Sensor> sensors;
  for (auto& column : dataset.columns) {
    if (!is_structure_temperature(column.channel)) continue;
    const auto frozen = frozen_rows(column.values);
    double p_spiked = 1, p_frozen = 1;
    const auto spiked = spiked_rows(column.values, p_spiked);
    for (const auto* rows : {&frozen, &spiked})
      for (const std::size_t row : *rows) column.values[row] = kMissing;
    if (!frozen.empty()) {
      p_frozen = chance_frozen(column.values, frozen.size());
      found.push_back({SensorFault::frozen, column.channel.symbol, "", frozen, 0, true, p_frozen});
    }
    if (!spiked.empty())
      found.push_back({SensorFault::spiked, column.channel.symbol, "", spiked, 0, true, p_spiked});
    sensors.push_back({&column, 0, {}, {}});
  }
  std::vector<std::vector<double>> beyond;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    beyond.push_back(beyond_the_others(sensors, s));
    find_jumps(sensors[s], beyond[s], dataset);
  }
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    std::vector<std::size_t> looked_at = sensors[s].jumps;
    looked_at.insert(looked_at.end(), sensors[s].suspects.begin(), sensors[s].suspects.end());
    for (const std::size_t row : looked_at) {
      const bool shown = sensors[s].jumps_at(row);
      std::vector<std::size_t> together;
      for (std::size_t other = 0; other < sensors.size(); ++other)
        if (sensors[other].jumps_at(row)) together.push_back(other);
      auto& values = sensors[s].column->values;
      double size = level_change(beyond[s], row);
      std::vector<std::size_t> rows;
      for (std::size_t i = row; i < dataset.rows; ++i) rows.push_back(i);
      const auto partner = std::ranges::find_if(together, [&](std::size_t other) {
        if (other == s || !shown) return false;
        const auto& theirs = sensors[other].column->values;
        const double apart = theirs[row - 1] - values[row - 1];
        return std::abs(level_change(values, row) - apart) < 0.1 * std::abs(apart) &&
               std::abs(level_change(theirs, row) + apart) < 0.1 * std::abs(apart);
      });
      const double as_read = two_ln_likelihood(dataset, {});
      if (partner != together.end()) {
        auto& theirs = sensors[*partner].column->values;
        for (const std::size_t i : rows) std::swap(values[i], theirs[i]);
        const double gain = two_ln_likelihood(dataset, {}) - as_read;
        if (gain < kEvidence) {
          for (const std::size_t i : rows) std::swap(values[i], theirs[i]);
          continue;
        }
        std::erase(sensors[*partner].jumps, row);
        found.push_back({SensorFault::swapped, sensors[s].column->channel.symbol,
                         sensors[*partner].column->channel.symbol, rows, level_change(values, row),
                         true, by_outputs(gain)});
        continue;
      }
      if (together.size() > 1 && 2 * together.size() > sensors.size()) continue;  // the room did
      const bool by_readings_alone = shown && !goes_on_as_ramp(beyond[s], row, size);
      const std::vector<double> as_read_values = values;
      double gain = -INFINITY;
      for (const double one : {size, own_change(as_read_values, row), own_change(beyond[s], row)}) {
        if (by_readings_alone && gain > -INFINITY) break;
        for (const std::size_t i : rows) values[i] = as_read_values[i] - one;
        const double with_it = two_ln_likelihood(dataset, {}) - as_read;
        if (with_it > gain) gain = with_it, size = one;
      }
      values = as_read_values;
      const double resolution = resolution_of(values);
      const double at_row = std::max(chance_at_row(as_read_values, row, resolution),
                                     chance_at_row(beyond[s], row, resolution));
      bool mended = gain >= kEvidence;
      if (!mended && !by_readings_alone) continue;
      const double free = two_ln_likelihood(dataset, {row, 0, true}) - as_read;
      // The size is known to a usual change: a part of the outputs' step is left for it.
      const double unsure = std::max(usual_change(beyond[s]), resolution) / size;
      if (!by_readings_alone &&
          (free - gain > lost_by_chance(outputs) * (1 + free * unsure * unsure) ||
           chance_of_knock(at_row, free, gain, outputs) * static_cast<double>(sensors.size()) >
               alpha))
        continue;
      const double slowly = best_with_lag(dataset, values, two_ln_likelihood) - as_read;
      if (slowly >= kEvidence && slowly >= std::max(gain, free) - kOverLag) continue;
      for (const std::size_t i : rows) values[i] = as_read_values[i] - size;
      const bool followed = gain < -lost_by_chance(outputs) &&
                            outputs_follow(dataset, values, size, row, as_read, two_ln_likelihood);
      if (!mended) values = as_read_values;
      if (followed && !outputs_step_too(dataset, outputs, row, two_ln_likelihood)) continue;
      const double by_readings = chance_of_as_many(at_row, 1, values.size());
      found.push_back({SensorFault::jumped, sensors[s].column->channel.symbol, "", rows, size,
                       mended, of_both(by_readings, by_outputs(gain)),
                       mended || stands_alone(sensors, s, row)});
    }
  }
  for (auto& one : found) {
    one.p = std::min(1.0, one.p * static_cast<double>(sensors.size()));
    one.named = one.named && one.p <= alpha;
  }
  return found;
}

}  // namespace driftwise::diagnosis
