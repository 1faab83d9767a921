#include "server/diagnosis/rows/sensor_changes.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kNeighbours = 4;     // rows to either side that tell the trend
constexpr double kRamp = 0.25;             // of a jump, within a few rows after it
constexpr std::size_t kMostLookedAt = 16;  // per sensor, jumps and suspects each, the largest
constexpr std::size_t kRowsPerSensor = 10;
constexpr double kRounded = 0.41;   // standard deviation of the change of two rounded values, steps
constexpr std::size_t kAlike = 30;  // rows that tell what is usual beside such a change
constexpr double kLouder = 1.5;     // times the usual: 30 rows know a spread to 13 %
constexpr std::size_t kSpan = 3;  // rows of a change that foretells: more than the readings' steps

// The usual change from row to row about this row: a room that warms takes all rows along.
double trend_about(const std::vector<double>& v, std::size_t row) {
  std::vector<double> about;
  for (std::size_t i = row > kNeighbours ? row - kNeighbours : 1;
       i <= std::min(row + kNeighbours, v.size() - 1); ++i)
    if (i != row && std::isfinite(v[i]) && std::isfinite(v[i - 1]))
      about.push_back(v[i] - v[i - 1]);
  return about.empty() ? 0 : median(about);
}

// Of values in steps of 0.01 K the middle one is one step or none: the spread of those near it.
double spread_near(const std::vector<double>& values) {
  const double near = kMoves * robust_sd(values);
  double sum = 0, count = 0;
  for (const double value : values)
    if (std::abs(value) <= near) sum += value * value, ++count;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace

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

double resolution_of(const std::vector<double>& v) {
  double smallest = INFINITY;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::abs(v[i] - v[i - 1]) > 0) smallest = std::min(smallest, std::abs(v[i] - v[i - 1]));
  return std::isfinite(smallest) ? smallest : 0;
}

double own_change(const std::vector<double>& v, std::size_t row) {
  return v[row] - v[row - 1] - trend_about(v, row);
}

std::vector<double> own_changes(const std::vector<double>& v) {
  std::vector<double> result(v.size(), 0);
  for (std::size_t i = 1; i < v.size(); ++i) result[i] = own_change(v, i);
  return result;
}

std::vector<std::size_t> largest_changes(std::vector<std::size_t> rows,
                                         const std::vector<double>& beyond) {
  std::ranges::stable_sort(rows, std::ranges::greater{},
                           [&](std::size_t i) { return std::abs(own_change(beyond, i)); });
  rows.resize(std::min(rows.size(), kMostLookedAt));
  std::ranges::sort(rows);
  return rows;
}

double level_change(const std::vector<double>& v, std::size_t row) {
  std::vector<double> before, after;
  for (std::size_t k = 0; k < kWindow; ++k) {
    if (row >= k + 1 && std::isfinite(v[row - 1 - k])) before.push_back(v[row - 1 - k]);
    if (row + k < v.size() && std::isfinite(v[row + k])) after.push_back(v[row + k]);
  }
  return median(after) - median(before) - static_cast<double>(kWindow) * trend_about(v, row);
}

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

bool stands_alone(const std::vector<Sensor>& sensors, std::size_t sensor, std::size_t row) {
  for (std::size_t other = 0; other < sensors.size(); ++other) {
    if (other == sensor) continue;
    const auto& v = sensors[other].column->values;
    if (std::abs(own_change(v, row)) > kMoves * sensors[other].usual) return false;
  }
  return sensors.size() > 1;
}

double usual_change(const std::vector<double>& v) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::isfinite(v[i]) && std::isfinite(v[i - 1])) changes.push_back(own_change(v, i));
  return spread_near(changes);
}

double chance_at_row(const std::vector<double>& v, std::size_t row, double resolution) {
  std::vector<double> others;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (std::isfinite(v[i]) && std::isfinite(v[i - 1]) && i != row)
      others.push_back(own_change(v, i));
  return student_law(others, resolution).beyond(own_change(v, row));
}

std::vector<double> usual_beside_others(const std::vector<Sensor>& sensors, std::size_t sensor,
                                        const std::vector<double>& beyond) {
  const double usual = usual_change(beyond);
  std::vector<double> result(beyond.size(), usual);
  struct Row {
    std::size_t at;
    double others, own;  // others: root mean square of their changes over the usual ones
  };
  const auto change_of = [](const Sensor& one, std::size_t i) {
    return one.changes.empty() ? own_change(one.column->values, i) : one.changes[i];
  };
  std::vector<Row> rows;
  for (std::size_t i = 1; i < beyond.size(); ++i) {
    double sum = 0, count = 0;
    for (std::size_t other = 0; other < sensors.size(); ++other)
      if (other != sensor && sensors[other].usual > 0)
        sum += std::pow(change_of(sensors[other], i) / sensors[other].usual, 2), ++count;
    const double own = own_change(beyond, i);
    if (count > 0 && std::isfinite(sum) && std::isfinite(own))
      rows.push_back({i, std::sqrt(sum / count), own});
  }
  if (rows.size() < 2 * kAlike) return result;
  std::ranges::stable_sort(rows, {}, &Row::others);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t first = std::min(k > kAlike / 2 ? k - kAlike / 2 : 0, rows.size() - kAlike);
    std::vector<double> alike;
    for (std::size_t j = first; j < first + kAlike; ++j)
      if (j != k) alike.push_back(rows[j].own);
    if (const double here = spread_near(alike); here > kLouder * usual) result[rows[k].at] = here;
  }
  return result;
}

void find_jumps(Sensor& sensor, const std::vector<double>& beyond,
                const std::vector<double>& usual_beside, const Dataset& dataset) {
  const auto& time_s = dataset.time_s;
  const auto begins = [](const std::vector<std::int64_t>& of, std::size_t i) {
    return !of.empty() && of[i] != of[i - 1];
  };
  const auto& v = sensor.column->values;
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  // Of values in steps of 0.01 K most do not change: that says nothing of a ramp of one step a row.
  const double resolution = resolution_of(v);
  const double step_s = median(steps);
  const auto stands_out = [&](std::size_t i, double least) {
    return std::abs(own_change(beyond, i)) > least && std::abs(own_change(v, i)) > least / 2 &&
           std::abs(level_change(beyond, i)) > 0.7 * least;
  };
  for (std::size_t i = kWindow; i + kWindow < v.size(); ++i) {
    if (!time_s.empty() && time_s[i] - time_s[i - 1] > 3 * step_s) continue;  // it had the time
    if (begins(dataset.run, i) || begins(dataset.datum, i)) continue;         // likewise
    const double usual = usual_beside[i];
    if (stands_out(i, std::max(kFarOffSensor * std::max(usual, resolution), kSmallest_k)))
      sensor.jumps.push_back(i);
    else if (stands_out(i, kMoves * std::max(usual, kRounded * resolution)))
      sensor.suspects.push_back(i);
  }
  sensor.suspects = largest_changes(std::move(sensor.suspects), beyond);
}

std::vector<char> after_a_pause(const Dataset& dataset) {
  constexpr double kPause = 2;  // usual steps
  std::vector<char> result(dataset.rows, 0);
  std::vector<double> steps;
  for (std::size_t i = 1; i < dataset.time_s.size(); ++i)
    steps.push_back(dataset.time_s[i] - dataset.time_s[i - 1]);
  if (steps.empty()) return result;
  const double usual = median(steps);
  for (std::size_t i = 0; i < steps.size(); ++i) result[i + 1] = steps[i] > kPause * usual ? 1 : 0;
  return result;
}

}  // namespace driftwise::diagnosis
