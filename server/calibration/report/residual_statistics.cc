#include "server/calibration/report/residual_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr double kSamePose = 1e-3;  // of a channel's range
constexpr double kWidestPose =
    1e-2;  // a chain of neighbours longer than this is a continuum, not a repeated pose

// A label per row: rows whose values differ by less than a step share it. Empty: the values form a
// continuum. The values are sorted into bins of a step: neighbours further apart never share one.
std::vector<double> labels(std::span<const double> values, const std::vector<std::size_t>& rows,
                           double min, double max) {
  const double range = max - min, step = kSamePose * range;
  struct Bin {
    double low = HUGE_VAL, high = -HUGE_VAL, start = 0;
  };
  std::vector<Bin> bins(static_cast<std::size_t>(std::lround(1 / kSamePose)) + 1);
  const auto bin_of = [&](double value) -> Bin& {
    const auto at = static_cast<std::size_t>(std::max(0.0, (value - min) / step));
    return bins[std::min(at, bins.size() - 1)];
  };
  for (const std::size_t row : rows) {
    Bin& bin = bin_of(values[row]);
    bin.low = std::min(bin.low, values[row]);
    bin.high = std::max(bin.high, values[row]);
  }
  double start = min, last = min;
  for (auto& bin : bins) {
    if (bin.low > bin.high) continue;
    if (bin.low - last > step) start = bin.low;
    if (bin.high - start > kWidestPose * range) return {};
    last = bin.high;
    bin.start = start;
  }
  std::vector<double> label(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) label[i] = bin_of(values[rows[i]]).start;
  return label;
}

// Rows that agree in several columns, each column's bits taken in turn.
class RowGroups {
 public:
  explicit RowGroups(std::size_t rows) : key_(rows, 0) {}

  template <class Value>  // (row) -> double
  void tell_apart_by(Value value) {
    for (std::size_t row = 0; row < key_.size(); ++row) {
      const auto bits = std::bit_cast<std::uint64_t>(value(row) + 0.0);  // one zero, not two
      // splitmix64 (Steele, Lea and Flood 2014): 64 bits, so that two of a million unlike rows fall
      // together once in 4e7 data sets.
      std::uint64_t mixed = key_[row] * 0x9e3779b97f4a7c15u + bits + 0x9e3779b97f4a7c15u;
      mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9u;
      mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
      key_[row] = mixed ^ (mixed >> 31);
    }
  }
  // Group per row, numbered by appearance. An open table: of a million keys, mostly unlike, it is
  // some times faster than std::unordered_map.
  std::vector<std::size_t> numbers(std::size_t& groups) const {
    constexpr std::size_t kEmpty = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> number(key_.size());
    std::vector<std::size_t> table(std::bit_ceil(2 * key_.size() + 1), kEmpty);
    groups = 0;
    for (std::size_t row = 0; row < key_.size(); ++row) {
      std::size_t place = key_[row] & (table.size() - 1);
      while (table[place] != kEmpty && key_[table[place]] != key_[row])
        place = (place + 1) & (table.size() - 1);
      if (table[place] == kEmpty) {
        table[place] = row;
        number[row] = groups++;
      } else {
        number[row] = number[table[place]];
      }
    }
    return number;
  }

 private:
  std::vector<std::uint64_t> key_;
};

std::optional<PureError> from_exact_repeats(const Design& design, Index output) {
  const std::size_t rows = design.rows.size();
  RowGroups by_row(rows);
  std::vector<std::size_t> number;
  std::size_t groups = 1;
  for (std::size_t v = 0; v < design.variables.size(); ++v) {
    const auto values = design.columns.values(v);
    by_row.tell_apart_by([&](std::size_t row) { return values[design.rows[row]]; });
    // Most data are told apart by their first few columns.
    if (v > 0 && v + 1 < design.variables.size()) continue;
    number = by_row.numbers(groups);
    if (groups == rows) return std::nullopt;
  }
  if (number.empty()) number.assign(rows, 0);
  const auto measured = design.columns.output(static_cast<std::size_t>(output));
  std::vector<double> mean(groups, 0), count(groups, 0);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t group = number[row];
    mean[group] += (measured[design.rows[row]] - mean[group]) / ++count[group];
  }
  PureError result{0, static_cast<int>(rows - groups), true};
  double squares = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const double error = measured[design.rows[row]] - mean[number[row]];
    squares += error * error;
  }
  result.sd = std::sqrt(squares / result.dof);
  return result;
}

std::optional<PureError> from_repeated_poses(const Design& design,
                                             const Eigen::VectorXd& residuals) {
  const std::size_t rows = design.rows.size();
  RowGroups poses(rows);
  bool any_pose = false;
  for (std::size_t v = 0; v < design.variables.size(); ++v) {
    const auto& variable = design.variables[v];
    if (!is_pose_symbol(variable.name) || variable.max == variable.min) continue;
    const auto label = labels(design.columns.values(v), design.rows, variable.min, variable.max);
    if (label.empty()) return std::nullopt;
    any_pose = true;
    poses.tell_apart_by([&](std::size_t row) { return label[row]; });
  }
  if (!any_pose) return std::nullopt;
  poses.tell_apart_by([&](std::size_t row) { return design.datum[row]; });
  std::size_t groups = 0;
  const auto number = poses.numbers(groups);
  std::vector<double> last(groups, std::nan(""));
  PureError result;
  double squares = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const double residual = residuals[static_cast<Index>(row)];
    double& before = last[number[row]];
    if (!std::isnan(before)) {
      squares += (residual - before) * (residual - before) / 2;
      ++result.dof;
    }
    before = residual;
  }
  if (result.dof < 3) return std::nullopt;
  result.sd = std::sqrt(squares / result.dof);
  return result;
}

}  // namespace

double lag1_autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& residuals) {
  const Index n = residuals.size();
  if (n < 3) return 0;
  const Eigen::VectorXd centred = residuals.array() - residuals.mean();
  const double squares = centred.squaredNorm();
  return squares > 0 ? centred.head(n - 1).dot(centred.tail(n - 1)) / squares : 0;
}

double effective_rows(std::int64_t rows, double lag1) {
  const auto n = static_cast<double>(rows);
  return std::clamp(n * (1 - lag1) / (1 + lag1), std::min(1.0, n), n);
}

std::optional<PureError> pure_error(const Design& design, Index output,
                                    const Eigen::VectorXd& residuals) {
  if (design.weighted || design.rows.size() < 3) return std::nullopt;
  if (auto exact = from_exact_repeats(design, output)) return exact;
  return from_repeated_poses(design, residuals);
}

}  // namespace driftwise::calibration
