#include "server/correction/return_subtraction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

std::int64_t datum_of(const JoinPart& part, std::size_t row) {
  return part.data.datum.empty() ? 0 : part.data.datum[row];
}

std::string base_symbol(const std::string& symbol) {
  constexpr std::string_view kPath = "_path";
  return symbol.ends_with(kPath) ? symbol.substr(0, symbol.size() - kPath.size()) : symbol;
}

// Returns of each datum that gave a value of this column, in time order.
std::map<std::int64_t, std::vector<std::size_t>> returns_by_datum(
    const JoinPart& part, const std::vector<std::size_t>& zeros, const DatasetColumn& column) {
  std::map<std::int64_t, std::vector<std::size_t>> by_datum;
  for (const auto row : zeros)
    if (!is_missing(column.values[row]) && !part.data.is_excluded(row))
      by_datum[datum_of(part, row)].push_back(row);
  return by_datum;
}

double on_line(const std::vector<double>& time_s, const std::vector<double>& values,
               std::size_t before, std::size_t after, double at_s) {
  const double span_s = time_s[after] - time_s[before];
  const double share = span_s > 0 ? (at_s - time_s[before]) / span_s : 0.5;
  return values[before] + (values[after] - values[before]) * share;
}

// Zero at the instant of a row; returns: of its datum, in time order.
double zero_at(const Dataset& data, const std::vector<double>& values,
               const std::vector<std::size_t>& returns, std::size_t row) {
  const double at_s = data.time_s[row];
  if (at_s <= data.time_s[returns.front()]) return values[returns.front()];
  if (at_s >= data.time_s[returns.back()]) return values[returns.back()];
  const auto after = std::ranges::upper_bound(
      returns, at_s, {}, [&data](std::size_t zero) { return data.time_s[zero]; });
  return on_line(data.time_s, values, *(after - 1), *after, at_s);
}

}  // namespace

bool counts_from_zero(const Channel& channel) {
  return is_pose_symbol(base_symbol(channel.symbol)) &&
         (is_length(channel.unit) || is_angle(channel.unit));
}

std::map<std::string, double> scatter_of_returns(const JoinPart& part,
                                                 const std::vector<std::size_t>& zeros) {
  std::map<std::string, double> scatter;
  for (const auto& column : part.data.columns) {
    if (!counts_from_zero(column.channel)) continue;
    std::vector<double> off;
    for (const auto& [datum, rows] : returns_by_datum(part, zeros, column))
      for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
        const double there = part.data.time_s.empty()
                                 ? 0.5 * (column.values[rows[i - 1]] + column.values[rows[i + 1]])
                                 : on_line(part.data.time_s, column.values, rows[i - 1],
                                           rows[i + 1], part.data.time_s[rows[i]]);
        off.push_back(column.values[rows[i]] - there);
      }
    // Variance of a value less the mean of two others: 1.5 of one.
    if (!off.empty()) scatter[column.channel.name()] = robust_sigma(off) / std::sqrt(1.5);
  }
  return scatter;
}

std::vector<double> without_jumps(const std::vector<double>& values) {
  constexpr double kFarOff = 5;
  std::vector<double> off;
  for (std::size_t i = 1; i + 1 < values.size(); ++i)
    off.push_back(values[i] - 0.5 * (values[i - 1] + values[i + 1]));
  const double limit = kFarOff * robust_sigma(off);
  std::vector<double> kept;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool inner = i > 0 && i + 1 < values.size();
    if (!inner || limit <= 0 || std::abs(off[i - 1]) <= limit) kept.push_back(values[i]);
  }
  return kept;
}

namespace {

// Sum of squares about their centre, datum by datum, in the column's unit. Each datum's centre
// takes one degree of freedom: a single return says nothing of its error.
struct Squares {
  double sum = 0, degrees = 0;
  double mean() const { return degrees > 0 ? sum / degrees : 0; }
};
Squares squares_of_returns(const JoinPart& part, const std::vector<std::size_t>& zeros,
                           const DatasetColumn& column) {
  Squares squares;
  for (const auto& [datum, rows] : returns_by_datum(part, zeros, column)) {
    std::vector<double> values;
    for (const auto row : rows) values.push_back(column.values[row]);
    const double centre = centre_of(values);
    const auto kept = without_jumps(values);
    if (kept.size() < 2) continue;
    for (const double value : kept) squares.sum += (value - centre) * (value - centre);
    squares.degrees += static_cast<double>(kept.size() - 1);
  }
  return squares;
}

// Mean square of the motors' own deviations at the returns, mean over the motors, mm^2.
double holding_square_mm2(const JoinPart& part, const std::vector<std::size_t>& zeros) {
  double sum = 0, motors = 0;
  for (const auto& column : part.data.columns) {
    if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit)) continue;
    const double mm = mm_from_nm(summary_unit(column.channel.unit).factor);
    sum += mm * mm * squares_of_returns(part, zeros, column).mean();
    motors += 1;
  }
  return motors > 0 ? sum / motors : 0;
}

}  // namespace

std::map<std::string, double> spread_of_returns(const JoinPart& part,
                                                const std::vector<std::size_t>& zeros) {
  std::map<std::string, double> spread;
  const double holding_mm2 = holding_square_mm2(part, zeros);
  for (const auto& column : part.data.columns) {
    if (!counts_from_zero(column.channel)) continue;
    const auto squares = squares_of_returns(part, zeros, column);
    if (squares.degrees == 0) continue;
    double square = squares.mean();
    if (is_length(column.channel.unit)) {
      const double mm = mm_from_nm(summary_unit(column.channel.unit).factor);
      square = std::max(0.0, square - holding_mm2 / mm / mm);
    }
    spread[column.channel.name()] = std::sqrt(square);
  }
  return spread;
}

void align_zeros(const std::vector<std::size_t>& zeros, JoinPart& part) {
  for (auto& column : part.data.columns) {
    if (!counts_from_zero(column.channel)) continue;
    std::map<std::int64_t, double> centre;
    std::vector<double> all;
    for (const auto& [datum, rows] : returns_by_datum(part, zeros, column)) {
      std::vector<double> values;
      for (const auto row : rows) values.push_back(column.values[row]);
      all.insert(all.end(), values.begin(), values.end());
      centre[datum] = centre_of(values);
    }
    const double of_all = centre_of(all);
    for (std::size_t row = 0; row < part.data.rows; ++row) {
      const auto found = centre.find(datum_of(part, row));
      column.values[row] -= found == centre.end() ? of_all : found->second;
    }
  }
}

Result<void> subtract_returns(const std::vector<std::size_t>& zeros, JoinPart& part) {
  if (part.data.time_s.empty() || zeros.size() < 2)
    return fail(ErrorCode::invalid_argument, reasons::kNoPoseZero,
                fmt::format("{}: found {} returns to zero{}, expected two at least, with time_s: "
                            "join without subtracting returns",
                            part.name, zeros.size(),
                            part.data.time_s.empty() ? " and no column time_s" : ""));
  for (auto& column : part.data.columns) {
    if (!counts_from_zero(column.channel)) continue;
    const auto by_datum = returns_by_datum(part, zeros, column);
    const std::vector<double> as_read = column.values;
    for (std::size_t row = 0; row < part.data.rows; ++row) {
      const auto found = by_datum.find(datum_of(part, row));
      // A datum without a return has no zero of its own: its rows have no value.
      column.values[row] = found == by_datum.end()
                               ? kMissing
                               : as_read[row] - zero_at(part.data, as_read, found->second, row);
    }
  }
  return {};
}

}  // namespace driftwise::correction
