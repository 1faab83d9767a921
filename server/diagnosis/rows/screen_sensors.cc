#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "server/core/data/reading.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/coarse_readings.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/rows/jump_witnesses.h"
#include "server/diagnosis/rows/screen.h"
#include "server/diagnosis/rows/sensor_changes.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestRows = 40;

// Rows of the longest run of one value, where it is a tenth of all and so many times longer than
// any other.
std::vector<std::size_t> frozen_rows(const std::vector<double>& values, double times) {
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
  if (longest < values.size() / 10 ||
      static_cast<double>(longest) < times * static_cast<double>(second) ||
      longest == values.size())
    return rows;
  for (std::size_t i = begin + 1; i < begin + longest; ++i) rows.push_back(i);
  return rows;
}

// Share of the readings that repeat the one before. Up to a half, noise moves the display from row
// to row, and does so while the part stands still.
double share_of_repeats(const std::vector<double>& values) {
  double same = 0, pairs = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (std::isfinite(values[i]) && std::isfinite(values[i - 1]))
      same += values[i] == values[i - 1] ? 1 : 0, pairs += 1;
  return (same + 1) / (pairs + 2);
}
constexpr double kTrembles = 0.5, kSurely = 1e-9;

// Of a run of `length` equal readings anywhere, by how often the others repeat the one before.
double chance_frozen(const std::vector<double>& values, std::size_t length) {
  return std::min(1.0, static_cast<double>(values.size()) *
                           std::pow(share_of_repeats(values), static_cast<double>(length)));
}

// Steps of a display, from which it cannot have stood still.
constexpr double kMoved = 2, kSurelyMoved = 4;
// Of the longest run of one value over the next one: by itself, and where the part has moved
// meanwhile.
constexpr double kTimesLonger = 10, kTimesLongerMoved = 2.5;

// Course of one thermometer over its frozen rows as the others foretell it from the rows around, K.
struct Foretold {
  double range = 0;  // over the frozen rows
  double own = 0;    // of the readings around
  double sd = 0;     // that they miss the readings around by
};

std::optional<Foretold> foretold_by_others(const Dataset& dataset, const DatasetColumn& column,
                                           const std::vector<std::size_t>& frozen) {
  const auto& own = column.values;
  const std::size_t first = frozen.front(), last = frozen.back();
  std::vector<const DatasetColumn*> others;
  for (const auto& other : dataset.columns)
    if (&other != &column && is_structure_temperature(other.channel)) others.push_back(&other);
  const auto is_whole = [&](std::size_t row) {
    return std::isfinite(own[row]) && std::ranges::all_of(others, [row](const auto* other) {
             return std::isfinite(other->values[row]);
           });
  };
  std::vector<std::size_t> outside, within;
  for (std::size_t row = 0; row < own.size(); ++row)
    if (is_whole(row)) (row < first || row > last ? outside : within).push_back(row);
  if (others.empty() || outside.size() < kFewestRows || within.empty()) return {};
  const auto columns = [&](const std::vector<std::size_t>& rows) {
    Eigen::MatrixXd x = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(rows.size()),
                                              static_cast<Eigen::Index>(others.size()) + 1);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t o = 0; o < others.size(); ++o)
        x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(o)) =
            others[o]->values[rows[i]] - others[o]->values[outside.front()];
    return x;
  };
  Eigen::VectorXd y(static_cast<Eigen::Index>(outside.size()));
  for (std::size_t i = 0; i < outside.size(); ++i)
    y[static_cast<Eigen::Index>(i)] = own[outside[i]] - own[first];
  const Eigen::MatrixXd around = columns(outside);
  const Eigen::VectorXd b = around.colPivHouseholderQr().solve(y);
  const Eigen::VectorXd foretold = columns(within) * b;
  return Foretold{foretold.maxCoeff() - foretold.minCoeff(), y.maxCoeff() - y.minCoeff(),
                  (y - around * b).norm() / std::sqrt(static_cast<double>(y.size()))};
}

// Has the part moved while this display stood still? It has where the display comes back elsewhere,
// or where the others foretell it, by four times what they miss the rows around by: two of its
// steps, a step being what it changes by from row to row; or four of the display's.
bool moved_meanwhile(const Dataset& dataset, const DatasetColumn& column, double display,
                     double step, const std::vector<std::size_t>& frozen) {
  const auto& own = column.values;
  const std::size_t last = frozen.back();
  if (last + 1 < own.size() && std::abs(own[last + 1] - own[last]) >= kMoved * step) return true;
  const auto foretold = foretold_by_others(dataset, column, frozen);
  if (!foretold) return false;
  if (foretold->range < kSurelyMoved * foretold->sd) return false;
  return (foretold->own >= kMoved * step && foretold->range >= kMoved * step) ||
         foretold->range >= kSurelyMoved * display;
}

// Largest change from one value to the next.
double largest_change(const std::vector<double>& values) {
  double largest = 0, before = NAN;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (std::isfinite(before)) largest = std::max(largest, std::abs(value - before));
    before = value;
  }
  return largest;
}

// The same of rows that follow one another.
double largest_change_from_row_to_row(const std::vector<double>& values) {
  double largest = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double change = std::abs(values[i] - values[i - 1]); std::isfinite(change))
      largest = std::max(largest, change);
  return largest;
}

// A display of tenths stands still for hours where nothing warms, and trembles at the edge between
// two of its values.
std::vector<std::size_t> frozen_rows(const Dataset& dataset, const DatasetColumn& column) {
  auto rows = frozen_rows(column.values, kTimesLonger);
  const bool surely = !rows.empty();
  if (!surely) rows = frozen_rows(column.values, kTimesLongerMoved);
  if (rows.empty()) return rows;
  std::vector<double> around = column.values;
  for (const std::size_t row : rows) around[row] = kMissing;
  if (share_of_repeats(around) <= kTrembles && chance_frozen(around, rows.size()) <= kSurely)
    return rows;
  double step = display_step(around, kWidestDisplay_K);
  if (step == 0) {
    const double of_all = display_step(column.values, kWidestDisplay_K);
    if (largest_change(around) < kMoved * of_all) step = of_all;
  }
  const double display = step > 0 ? step : display_step(column.values, kWidestDisplay_K);
  if (!surely) step = std::max(step, largest_change_from_row_to_row(around));
  if (step > 0 && !moved_meanwhile(dataset, column, display, step, rows)) rows.clear();
  return rows;
}

constexpr double kRounding = 1e-9;        // of a variance
constexpr std::size_t kLongestSpike = 5;  // rows
constexpr double kFlat = 0.25;            // of a spike: how much its rows may differ

// Of the first of `count` rows: how far its value lies off the mean of the ones before and after.
double off_the_neighbours(const std::vector<double>& v, std::size_t first, std::size_t count) {
  return v[first] - (v[first - 1] + v[first + count]) / 2;
}

// The same of every row by itself; 0 at the ends.
std::vector<double> off_the_neighbours(const std::vector<double>& v) {
  std::vector<double> apart(v.size(), 0);
  for (std::size_t i = 1; i + 1 < v.size(); ++i) apart[i] = off_the_neighbours(v, i, 1);
  return apart;
}

// Does another thermometer leave the values before and after these rows the same way, beyond its
// noise, and is that no more than the temperature otherwise moves by? Then the room did: rows that
// lie minutes apart see a door once.
bool room_left_too(const Dataset& dataset, const DatasetColumn& column, std::size_t first,
                   std::size_t count) {
  const auto& own = column.values;
  const double off = off_the_neighbours(own, first, count);
  double lowest = INFINITY, highest = -INFINITY;
  for (std::size_t i = 0; i < own.size(); ++i)
    if (std::isfinite(own[i]) && (i < first || i >= first + count))
      lowest = std::min(lowest, own[i]), highest = std::max(highest, own[i]);
  if (!(std::abs(off) < highest - lowest)) return false;
  return std::ranges::any_of(dataset.columns, [&](const DatasetColumn& other) {
    if (&other == &column || !is_structure_temperature(other.channel)) return false;
    const double theirs = off_the_neighbours(other.values, first, count);
    const double usual =
        std::max(robust_sd(off_the_neighbours(other.values)), resolution_of(other.values));
    return theirs * off > 0 && std::abs(theirs) > kMoves * usual;
  });
}

// Of single values, and of runs of them, that lie off the one before and the one after, which
// agree; p: of as many as these. A run is level and no pause lies at its ends: where a room warms
// while the robot rests, temperatures come back along a ramp.
std::vector<std::size_t> spiked_rows(const Dataset& dataset, const DatasetColumn& column,
                                     const std::vector<char>& after_a_pause, double& p) {
  const std::vector<double>& v = column.values;
  const std::vector<double> apart = off_the_neighbours(v);
  const double usual = std::max(robust_sd(apart), resolution_of(v));
  const double least = std::max(kFarOffSensor * usual, kSmallest_k);
  std::vector<std::size_t> rows;
  std::vector<char> tells(v.size(), 1);  // nothing of a spike beside it
  double nearest = INFINITY;
  const auto is_spike = [&](std::size_t first, std::size_t count) {
    const double before = v[first - 1], after = v[first + count], beside = (before + after) / 2;
    const double own = off_the_neighbours(v, first, count);
    if (count > 1 && (after_a_pause[first] != 0 || after_a_pause[first + count] != 0)) return false;
    for (std::size_t k = first; k < first + count; ++k)
      if (!(std::abs(v[k] - beside) > least) ||
          !(std::abs(v[k] - v[first]) <= kFlat * std::abs(own)))
        return false;
    // While a run lasts the part itself may warm.
    return std::abs(after - before) <
           (count > 1 ? std::max(least / 2, kFlat * std::abs(own)) : least / 2);
  };
  for (std::size_t i = 1; i + 1 < v.size(); ++i)
    for (std::size_t count = 1; count <= kLongestSpike && i + count < v.size(); ++count) {
      if (!is_spike(i, count) || room_left_too(dataset, column, i, count)) continue;
      const double beside = (v[i - 1] + v[i + count]) / 2;
      for (std::size_t k = i - 1; k <= i + count; ++k) tells[k] = 0;
      for (std::size_t k = i; k < i + count; ++k) {
        nearest = std::min(nearest, std::abs(v[k] - beside));
        rows.push_back(k);
      }
      i += count;  // the value after it is right
      break;
    }
  if (rows.empty()) return rows;
  std::vector<double> others;
  for (std::size_t i = 1; i + 1 < v.size(); ++i)
    if (tells[i] != 0 && std::isfinite(apart[i])) others.push_back(apart[i]);
  const StudentLaw law = student_law(others, resolution_of(v));
  p = chance_of_as_many(law.beyond(nearest), rows.size(), v.size());
  return rows;
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
  const auto n = static_cast<Eigen::Index>(problem.learn.size());
  if (n < 3) return 0;
  Eigen::MatrixXd news(n - 1, static_cast<Eigen::Index>(problem.outputs.size()));
  double two_ln = 0;
  for (Eigen::Index o = 0; o < news.cols(); ++o) {
    const Eigen::VectorXd left = rows_of(
        residuals(problem, problem.outputs[static_cast<std::size_t>(o)], columns), problem.learn);
    // Slow noise is no evidence of a jump: of each row what its neighbour before does not predict.
    const auto before = left.head(n - 1), after = left.tail(n - 1);
    const double share = std::clamp(before.dot(after) / before.squaredNorm(), 0.0, 0.99);
    const Eigen::VectorXd own = after - share * before;
    two_ln -= static_cast<double>(n) * std::log(own.squaredNorm());
    news.col(o) = own.normalized();
  }
  // One noise behind all legs of a robot is one witness.
  Eigen::MatrixXd correlation = news.transpose() * news;
  correlation.diagonal().array() += kRounding;
  const Eigen::VectorXd pivots = correlation.ldlt().vectorD();
  return two_ln - static_cast<double>(n) * pivots.cwiseMax(kRounding).array().log().sum();
}

OutputsLikelihood likelihood_of(
    std::function<std::optional<Problem>(const Dataset& dataset)> lay_out) {
  struct Laid {
    std::vector<std::vector<double>> readings;
    std::optional<Problem> problem;
  };
  const auto same = [](const std::vector<double>& one, const std::vector<double>& other) {
    return std::ranges::equal(
        one, other, [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); });
  };
  return [lay_out = std::move(lay_out), same, laid = std::make_shared<Laid>()](
             const Dataset& dataset, const FreeLevel& level) {
    const bool is_known =
        std::ranges::equal(laid->readings, dataset.columns, same, {}, &DatasetColumn::values);
    if (!is_known) {
      laid->problem = lay_out(dataset);
      laid->readings.clear();
      for (const auto& column : dataset.columns) laid->readings.push_back(column.values);
    }
    return laid->problem ? two_ln_likelihood(*laid->problem, level) : -INFINITY;
  };
}

std::vector<FaultySensor> mend_sensors(Dataset& dataset, std::size_t outputs, double alpha,
                                       const OutputsLikelihood& two_ln_likelihood,
                                       const std::function<bool()>& tick) {
  std::vector<FaultySensor> found;
  if (dataset.rows < kFewestRows) return found;
  const auto is_stopped = [&tick] { return tick && !tick(); };
  std::vector<Sensor> sensors;
  const auto pauses = after_a_pause(dataset);
  for (auto& column : dataset.columns) {
    if (!is_structure_temperature(column.channel)) continue;
    if (is_stopped()) return found;
    const auto frozen = frozen_rows(dataset, column);
    double p_spiked = 1, p_frozen = 1;
    const auto spiked = spiked_rows(dataset, column, pauses, p_spiked);
    for (const auto* rows : {&frozen, &spiked})
      for (const std::size_t row : *rows) column.values[row] = kMissing;
    if (!frozen.empty()) {
      p_frozen = chance_frozen(column.values, frozen.size());
      found.push_back({SensorFault::frozen, column.channel.symbol, "", frozen, 0, true, p_frozen});
    }
    if (!spiked.empty())
      found.push_back({SensorFault::spiked, column.channel.symbol, "", spiked, 0, true, p_spiked});
    const double usual = std::max(usual_change(column.values), resolution_of(column.values));
    sensors.push_back({&column, usual, {}, {}, own_changes(column.values)});
  }
  std::vector<std::vector<double>> beyond;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (is_stopped()) return found;
    beyond.push_back(beyond_the_others(sensors, s));
    find_jumps(sensors[s], beyond[s], usual_beside_others(sensors, s, beyond[s]), dataset);
  }
  JumpWitnesses witnesses(dataset, sensors, beyond, outputs, alpha, two_ln_likelihood);
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    std::vector<std::size_t> rows = largest_changes(sensors[s].jumps, beyond[s]);
    rows.insert(rows.end(), sensors[s].suspects.begin(), sensors[s].suspects.end());
    for (const std::size_t row : rows) {
      if (is_stopped()) return found;
      if (auto fault = witnesses.look_at(s, row)) found.push_back(std::move(*fault));
    }
  }
  for (auto& one : found) {
    one.p = std::min(1.0, one.p * static_cast<double>(sensors.size()));
    one.named = one.named && one.p <= alpha;
  }
  return found;
}

}  // namespace driftwise::diagnosis
