#include "server/diagnosis/rows/predicted_pose.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/core/try.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/aliases.h"
#include "server/diagnosis/rows/problem.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr int kDegreeOfOne = 5, kDegree = 3;
constexpr Eigen::Index kRowsPerColumn = 5;
constexpr std::size_t kFewestToRepeat = 4;
constexpr double kFewOf = 0.5;       // different values over rows
constexpr double kOnLattice = 1e-9;  // of the range
constexpr double kMostSites = 1e5;   // of a lattice that says something
constexpr double kSitesTaken = 0.1;  // of a lattice, by a reading in fine steps
constexpr double kNearShare = 0.1;   // of its values, that the noise does not tell from the next
constexpr double kToldApart = 3;     // standard deviations of the noise

struct Scaled {
  const std::vector<double>* values;
  double middle = 0, half = 1;
  double at(std::size_t row) const { return ((*values)[row] - middle) / half; }
};

std::optional<Scaled> scaled(const std::vector<double>& values) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : values)
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  if (!(high > low)) return std::nullopt;
  return Scaled{&values, (low + high) / 2, (high - low) / 2};
}

bool is_condition(const Channel& channel) {
  return is_structure_temperature(channel) || channel.unit == "degC" || channel.unit == "N" ||
         channel.unit == "hPa" || channel.unit == "pct";
}

// Exponents of all monomials up to a total degree.
std::vector<std::vector<int>> monomials(std::size_t variables, int degree) {
  std::vector<std::vector<int>> all = {std::vector<int>(variables, 0)};
  for (std::size_t v = 0; v < variables; ++v) {
    const std::size_t before = all.size();
    for (std::size_t i = 0; i < before; ++i) {
      int used = 0;
      for (const int e : all[i]) used += e;
      for (int e = 1; e + used <= degree; ++e) {
        auto more = all[i];
        more[v] = e;
        all.push_back(std::move(more));
      }
    }
  }
  return all;
}

// Least squares; rows far off the others are left out and it is fitted again: one lost reading of
// zero would bend what is predicted of every row.
Eigen::VectorXd without_gross_errors(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  constexpr double kFarOff = 8;  // robust standard deviations
  constexpr double kMostFarOff = 0.05;
  constexpr int kRounds = 5;
  Eigen::VectorXd b = x.colPivHouseholderQr().solve(y);
  Eigen::Index dropped = 0;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd left = y - x * b;
    const double far = kFarOff * robust_sd({left.data(), left.data() + left.size()});
    const Eigen::ArrayXd kept = (left.array().abs() <= far).cast<double>();
    const auto off = static_cast<Eigen::Index>(static_cast<double>(left.size()) - kept.sum());
    if (!(far > 0) || off == dropped ||
        static_cast<double>(off) > kMostFarOff * static_cast<double>(left.size()))
      break;
    dropped = off;
    b = (x.array().colwise() * kept)
            .matrix()
            .colPivHouseholderQr()
            .solve((y.array() * kept).matrix());
  }
  return b;
}

}  // namespace

bool repeats_exactly(const std::vector<double>& values) {
  std::vector<double> sorted;
  for (const double value : values)
    if (std::isfinite(value)) sorted.push_back(value);
  if (sorted.size() < kFewestToRepeat) return false;
  std::ranges::sort(sorted);
  const std::size_t rows = sorted.size();
  const double range = sorted.back() - sorted.front();
  sorted.erase(std::ranges::unique(sorted).begin(), sorted.end());
  if (static_cast<double>(sorted.size()) < kFewOf * static_cast<double>(rows)) return true;
  // Each place once, but all of them on one lattice.
  const double spacing = lattice_spacing(sorted, kOnLattice * range);
  return spacing > 0 && range < kMostSites * spacing;
}

bool is_read_in_steps(const std::vector<double>& values, double noise) {
  std::vector<double> sorted;
  for (const double value : values)
    if (std::isfinite(value)) sorted.push_back(value);
  std::ranges::sort(sorted);
  sorted.erase(std::ranges::unique(sorted).begin(), sorted.end());
  if (sorted.size() < kFewestToRepeat) return false;
  const double range = sorted.back() - sorted.front();
  const double spacing = lattice_spacing(sorted, kOnLattice * range);
  const auto count = static_cast<double>(sorted.size());
  if (!(spacing > 0) || count > kSitesTaken * range / spacing) return false;
  double near = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    near += sorted[i] - sorted[i - 1] < kToldApart * noise ? 1 : 0;
  return near > kNearShare * (count - 1);
}

std::size_t different_places(const std::vector<const std::vector<double>*>& coordinates) {
  if (coordinates.empty()) return 0;
  std::set<std::vector<double>> places;
  for (std::size_t row = 0; row < coordinates.front()->size(); ++row) {
    std::vector<double> place;
    for (const auto* values : coordinates)
      if (const double value = (*values)[row]; std::isfinite(value)) place.push_back(value);
    if (place.size() == coordinates.size()) places.insert(std::move(place));
  }
  return places.size();
}

namespace {

// Values within each datum that has enough rows; all of them where there are no datums.
std::vector<std::vector<double>> within_datums(const Dataset& dataset,
                                               const std::vector<double>& values) {
  if (dataset.datum.empty()) return {values};
  std::map<std::int64_t, std::vector<double>> of_datum;
  for (std::size_t row = 0; row < values.size(); ++row)
    if (std::isfinite(values[row])) of_datum[dataset.datum[row]].push_back(values[row]);
  std::vector<std::vector<double>> result;
  for (auto& [datum, some] : of_datum)
    if (some.size() >= kFewestToRepeat) result.push_back(std::move(some));
  return result;
}

}  // namespace

bool repeats_exactly(const Dataset& dataset, const std::vector<double>& values) {
  const auto datums = within_datums(dataset, values);
  return !datums.empty() &&
         std::ranges::all_of(datums, [](const auto& one) { return repeats_exactly(one); });
}

bool is_read_in_steps(const Dataset& dataset, const std::vector<double>& values, double noise) {
  return std::ranges::any_of(within_datums(dataset, values),
                             [noise](const auto& one) { return is_read_in_steps(one, noise); });
}

std::optional<std::vector<double>> predicted_coordinate(const Dataset& dataset,
                                                        const std::string& symbol) {
  const auto* own = dataset.find(symbol);
  if (own == nullptr) return std::nullopt;
  std::vector<Scaled> motors, conditions;
  for (const auto& column : dataset.columns) {
    if (column.channel.symbol == symbol) continue;
    const auto one = scaled(column.values);
    if (!one) continue;
    if (is_motor_symbol(column.channel.symbol)) motors.push_back(*one);
    if (is_condition(column.channel)) conditions.push_back(*one);
  }
  if (motors.empty()) return std::nullopt;
  if (!dataset.time_s.empty())
    if (const auto time = scaled(dataset.time_s)) conditions.push_back(*time);
  std::map<std::int64_t, Eigen::Index> datums;
  for (const auto id : dataset.datum) datums.emplace(id, static_cast<Eigen::Index>(datums.size()));
  std::vector<std::size_t> rows;
  const auto complete = [&](std::size_t row, bool with_conditions) {
    const auto finite = [row](const Scaled& one) { return std::isfinite((*one.values)[row]); };
    return std::ranges::all_of(motors, finite) &&
           (!with_conditions || std::ranges::all_of(conditions, finite));
  };
  const auto learns = [&](std::size_t row) {
    return std::isfinite(own->values[row]) && !dataset.is_excluded(row);
  };
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (learns(row) && complete(row, true)) rows.push_back(row);
  // Conditions that leave too few rows are done without.
  if (2 * rows.size() < dataset.rows) {
    conditions.clear();
    rows.clear();
    for (std::size_t row = 0; row < dataset.rows; ++row)
      if (learns(row) && complete(row, true)) rows.push_back(row);
  }
  int degree = motors.size() == 1 ? kDegreeOfOne : kDegree;
  auto powers = monomials(motors.size(), degree);
  const auto further = static_cast<Eigen::Index>(conditions.size()) +
                       std::max<Eigen::Index>(0, static_cast<Eigen::Index>(datums.size()) - 1);
  while (degree > 1 && (static_cast<Eigen::Index>(powers.size()) + further) * kRowsPerColumn >
                           static_cast<Eigen::Index>(rows.size()))
    powers = monomials(motors.size(), --degree);
  const Eigen::Index width = static_cast<Eigen::Index>(powers.size()) + further;
  if (static_cast<Eigen::Index>(rows.size()) < 2 * width) return std::nullopt;
  const auto fill = [&](std::size_t row, auto&& to) {
    Eigen::Index k = 0;
    for (const auto& exponents : powers) {
      double value = 1;
      for (std::size_t m = 0; m < motors.size(); ++m)
        for (int e = 0; e < exponents[m]; ++e) value *= motors[m].at(row);
      to[k++] = value;
    }
    for (const auto& condition : conditions) to[k++] = condition.at(row);
    for (const auto& [id, index] : datums)
      if (index > 0) to[k++] = dataset.datum[row] == id ? 1 : 0;
  };
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd x(n, width);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t row = rows[static_cast<std::size_t>(i)];
    fill(row, x.row(i));
    y[i] = own->values[row];
  }
  const Eigen::VectorXd b = without_gross_errors(x, y);
  std::vector<double> result = own->values;
  Eigen::RowVectorXd at(width);
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (!complete(row, true)) continue;
    fill(row, at);
    result[row] = at.dot(b.transpose());
  }
  return result;
}

namespace {

// Motor coordinates by the baseline at the pose that `prepared` has: rows x motors.
Result<Eigen::MatrixXd> motors_at(const Problem& problem, const Eigen::MatrixXd& coefficients) {
  DRIFTWISE_TRY(const auto columns, problem.prepared.columns(problem.base));
  return Eigen::MatrixXd(columns * coefficients);
}

// Of a coordinate, what the rows that learn are off the measured one.
double off_the_measured(const Problem& problem, const std::vector<double>& measured,
                        const Eigen::Ref<const Eigen::VectorXd>& pose) {
  std::vector<double> off;
  for (const std::size_t row : problem.learn)
    off.push_back(measured[row] - pose[static_cast<Eigen::Index>(row)]);
  const double middle = median(off);
  for (double& one : off) one -= middle;
  return robust_sd(std::move(off));
}

void set_pose(Problem& problem, const std::vector<std::string>& symbols,
              const Eigen::MatrixXd& pose) {
  for (std::size_t k = 0; k < symbols.size(); ++k) {
    const auto column = pose.col(static_cast<Eigen::Index>(k));
    problem.prepared.set_coordinate(symbols[k], {column.data(), column.data() + column.size()});
  }
}

}  // namespace

Result<void> solve_for_pose(Problem& problem, const Eigen::MatrixXd& at_measured) {
  constexpr int kRounds = 3;
  constexpr double kStep = 1e-3;  // of a coordinate's range: slopes are taken over it
  constexpr double kSeen = 0.01;  // of what the pose is off: less is the polynomial's own freedom
  std::vector<std::string> symbols;
  std::vector<std::vector<double>> measured;
  const Dataset& readings = problem.data();
  for (const auto& column : readings.columns) {
    if (!is_coordinate(problem, column.channel)) continue;
    if (!std::ranges::any_of(problem.base, [&](const effects::Term& term) {
          const auto read = effects::symbols_of(term);
          return std::ranges::find(read, column.channel.symbol) != read.end();
        }))
      continue;
    symbols.push_back(column.channel.symbol);
    measured.push_back(column.values);
  }
  const bool all_motors = std::ranges::all_of(
      problem.outputs, [](const auto& output) { return is_motor_symbol(output.channel.symbol); });
  if (symbols.size() < 2 || !all_motors || symbols.size() != problem.outputs.size()) return {};
  const auto rows = static_cast<Eigen::Index>(readings.rows);
  const auto size = static_cast<Eigen::Index>(symbols.size());
  Eigen::MatrixXd learned = rows_of(at_measured, problem.learn), motors(rows, size);
  const Eigen::RowVectorXd inverse = learned.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  learned = learned * inverse.asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(learned);
  Eigen::MatrixXd coefficients(at_measured.cols(), size);
  for (Eigen::Index o = 0; o < size; ++o) {
    const auto& output = problem.outputs[static_cast<std::size_t>(o)];
    motors.col(o) = output.measured;
    coefficients.col(o) =
        inverse.transpose().cwiseProduct(qr.solve(rows_of(output.measured, problem.learn)));
  }
  Eigen::MatrixXd first(rows, size);
  for (Eigen::Index k = 0; k < size; ++k)
    first.col(k) = Eigen::Map<const Eigen::VectorXd>(
        problem.prepared.conditions().values_of(symbols[static_cast<std::size_t>(k)]).data(), rows);
  Eigen::MatrixXd pose = first;
  for (int round = 0; round < kRounds; ++round) {
    set_pose(problem, symbols, pose);
    DRIFTWISE_TRY(const auto here, motors_at(problem, coefficients));
    std::vector<Eigen::MatrixXd> slopes;
    for (Eigen::Index k = 0; k < size; ++k) {
      const double step = kStep * (first.col(k).maxCoeff() - first.col(k).minCoeff());
      Eigen::MatrixXd moved = pose;
      moved.col(k).array() += step;
      set_pose(problem, symbols, moved);
      DRIFTWISE_TRY(const auto there, motors_at(problem, coefficients));
      slopes.emplace_back((there - here) / step);
    }
    for (Eigen::Index row = 0; row < rows; ++row) {
      Eigen::MatrixXd slope(size, size);
      for (Eigen::Index k = 0; k < size; ++k)
        slope.col(k) = slopes[static_cast<std::size_t>(k)].row(row).transpose();
      const Eigen::VectorXd by =
          slope.partialPivLu().solve((motors.row(row) - here.row(row)).transpose());
      if (by.allFinite()) pose.row(row) += by.transpose();
    }
  }
  bool nearer = false;
  for (Eigen::Index k = 0; k < size && pose.allFinite(); ++k) {
    const auto& of = measured[static_cast<std::size_t>(k)];
    const double before = off_the_measured(problem, of, first.col(k)),
                 after = off_the_measured(problem, of, pose.col(k));
    if (after > before) {
      nearer = false;
      break;
    }
    nearer = nearer || after < (1 - kSeen) * before;
  }
  set_pose(problem, symbols, nearer ? pose : first);
  return {};
}

}  // namespace driftwise::diagnosis
