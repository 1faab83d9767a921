#include "server/correction/join_suspicion.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

constexpr std::ptrdiff_t kMostShift = 3;
// Noise alone never halves a difference by shifting it: a shift of independent errors leaves their
// spread as it is.
constexpr double kMuchLess = 0.5;
constexpr std::size_t kFewRows = 8;

// Differences of one channel between two parts, and the row of each.
struct Differences {
  std::vector<double> off;
  std::vector<std::int64_t> row;
};

Differences differences_of(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                           std::size_t b, const Channel& of_a, const Channel& of_b,
                           std::ptrdiff_t shift) {
  const auto& first = parts[a].data.find(of_a.symbol)->values;
  const auto& second = parts[b].data.find(of_b.symbol)->values;
  Differences out;
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    const auto other = static_cast<std::ptrdiff_t>(k) + shift;
    if (other < 0 || other >= static_cast<std::ptrdiff_t>(rows.row.size())) continue;
    const double d =
        first[rows.index[a][k]] - second[rows.index[b][static_cast<std::size_t>(other)]];
    if (is_missing(d)) continue;
    out.off.push_back(d);
    out.row.push_back(rows.row[k]);
  }
  return out;
}

// Deviations from the median that two and three fifths of the rows do not exceed. Rows that are
// shifted behind a gap leave the rows before it as they are: a standard deviation sees both, and
// the one quantile that is the median deviation jumps by chance where values lie at two places, as
// differences of axes do that rest at +-30 nm. Both together do neither.
struct Closeness {
  double two_fifths = 0, three_fifths = 0;
  bool is_much_less_than(const Closeness& other) const {
    return two_fifths < kMuchLess * other.two_fifths &&
           three_fifths < kMuchLess * other.three_fifths;
  }
};

Closeness closeness_of(std::vector<double> off) {
  const double median = median_of(off);
  for (double& value : off) value = std::abs(value - median);
  std::ranges::sort(off);
  const auto at = [&off](std::size_t fifths) { return off[(off.size() - 1) * fifths / 5]; };
  return off.empty() ? Closeness{} : Closeness{at(2), at(3)};
}

bool is_compared(const Channel& channel) {
  return (is_pose_symbol(channel.symbol) || is_motor_symbol(channel.symbol)) &&
         (is_length(channel.unit) || is_angle(channel.unit));
}

std::string size_text(double size, const Channel& channel) {
  const auto unit = summary_unit(channel.unit);
  return quantity_text(unit.factor * size, unit.unit);
}

std::string shift_text(std::ptrdiff_t shift) {
  return fmt::format("{} row{} {}", std::abs(shift), std::abs(shift) == 1 ? "" : "s",
                     shift > 0 ? "later" : "earlier");
}

double spread_of(const JoinPart& part, const Channel& channel) {
  std::vector<double> values;
  for (const double value : part.data.find(channel.symbol)->values)
    if (!is_missing(value)) values.push_back(value);
  return robust_sigma(std::move(values));
}

// Sigma of what a quadratic polynomial of the motor coordinates leaves of a pose coordinate, with
// the pose taken from a row that is shifted; negative: it cannot be said.
double left_by_motors(const JoinPart& part, const std::vector<std::size_t>& order,
                      const DatasetColumn& pose, std::ptrdiff_t shift) {
  std::vector<const DatasetColumn*> motors;
  for (const auto& column : part.data.columns)
    if (is_motor_symbol(column.channel.symbol)) motors.push_back(&column);
  const std::size_t m = motors.size(), terms = 1 + m + m * (m + 1) / 2;
  if (m == 0) return -1;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // row of the motors, row of the pose
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto other = static_cast<std::ptrdiff_t>(k) + shift;
    if (other < 0 || other >= static_cast<std::ptrdiff_t>(order.size())) continue;
    const std::size_t at = order[k], from = order[static_cast<std::size_t>(other)];
    bool whole = !is_missing(pose.values[from]);
    for (const auto* motor : motors) whole = whole && !is_missing(motor->values[at]);
    if (whole) pairs.emplace_back(at, from);
  }
  if (pairs.size() < 3 * terms) return -1;
  Eigen::MatrixXd design(static_cast<Eigen::Index>(pairs.size()), static_cast<Eigen::Index>(terms));
  Eigen::VectorXd wanted(static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    Eigen::Index column = 0;
    design(row, column++) = 1;
    for (std::size_t i = 0; i < m; ++i) {
      const double qi = motors[i]->values[pairs[k].first];
      design(row, column++) = qi;
      for (std::size_t j = i; j < m; ++j)
        design(row, column++) = qi * motors[j]->values[pairs[k].first];
    }
    wanted(row) = pose.values[pairs[k].second];
  }
  const Eigen::VectorXd left = wanted - design * design.colPivHouseholderQr().solve(wanted);
  return robust_sigma({left.data(), left.data() + left.size()});
}

tl::unexpected<Error> shifted(const std::string& sentence) {
  return fail(ErrorCode::failed_precondition, reasons::kRowsShifted,
              sentence + ": look for a row that is missing or doubled in one of them");
}

Result<void> check_own_rows(const JoinPart& part) {
  std::vector<std::size_t> order(part.data.rows);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&part](std::size_t row) { return part.row_of(row); });
  for (const auto& column : part.data.columns) {
    if (!is_pose_symbol(column.channel.symbol)) continue;
    const double here = left_by_motors(part, order, column, 0);
    if (here <= 0) continue;
    for (const std::ptrdiff_t shift : {-1, 1}) {
      const double there = left_by_motors(part, order, column, shift);
      if (there >= 0 && there < kMuchLess * here)
        return shifted(fmt::format(
            "{} of {} follows the motor coordinates to {} when it is taken {}, to {} as it is",
            column.channel.name(), part.name, size_text(there, column.channel), shift_text(shift),
            size_text(here, column.channel)));
    }
  }
  return {};
}

Result<void> check_pair_shifted(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                                std::size_t b) {
  for (const auto& column : parts[a].data.columns) {
    if (!is_compared(column.channel)) continue;
    const auto* other = parts[b].data.find(column.channel.symbol);
    if (other == nullptr || other->channel != column.channel) continue;
    const auto off_by = [&](std::ptrdiff_t shift) {
      return differences_of(parts, rows, a, b, column.channel, column.channel, shift).off;
    };
    const auto here = off_by(0);
    if (here.size() < kFewRows) continue;
    for (std::ptrdiff_t size = 1; size <= kMostShift; ++size)
      for (const std::ptrdiff_t shift : {-size, size}) {
        const auto there = off_by(shift);
        if (there.size() < kFewRows || !closeness_of(there).is_much_less_than(closeness_of(here)) ||
            !(sigma_without_far_off(there) < sigma_without_far_off(here)))
          continue;
        return shifted(fmt::format(
            "{} of {} and {} agrees to {} in most rows when {} is taken {}, to {} as it is",
            column.channel.name(), parts[a].name, parts[b].name,
            size_text(robust_sigma(there), column.channel), parts[b].name, shift_text(shift),
            size_text(robust_sigma(here), column.channel)));
      }
  }
  return {};
}

tl::unexpected<Error> swapped(const std::string& sentence) {
  return fail(ErrorCode::failed_precondition, reasons::kSetupsSwapped,
              sentence + ": state the set-up that each run was really measured in");
}

Result<void> check_pair_swapped(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                                std::size_t b) {
  for (const auto& column : parts[a].data.columns) {
    if (!is_pose_symbol(column.channel.symbol)) continue;
    const auto* same = parts[b].data.find(column.channel.symbol);
    if (same == nullptr || same->channel != column.channel) continue;
    const auto own = difference_of(parts, rows, a, b, column.channel, column.channel);
    if (own.rows < kFewRows || own.sigma <= 0) continue;
    for (const auto& of_a : parts[a].data.columns)
      for (const auto& of_b : parts[b].data.columns) {
        if (!is_pose_symbol(of_a.channel.symbol) || !is_pose_symbol(of_b.channel.symbol) ||
            of_a.channel.symbol == of_b.channel.symbol ||
            of_a.channel.unit != column.channel.unit || of_b.channel.unit != column.channel.unit)
          continue;
        const auto cross = difference_of(parts, rows, a, b, of_a.channel, of_b.channel);
        // Agreement counts only where there is something to agree about.
        constexpr double kOfItsSpread = 0.1;
        if (cross.rows < kFewRows || !(cross.sigma < kMuchLess * own.sigma) ||
            !(cross.sigma < kOfItsSpread * spread_of(parts[a], of_a.channel)))
          continue;
        return swapped(
            fmt::format("{} of {} agrees with {} of {} to {}, while {} of both agrees "
                        "to {} only",
                        of_a.channel.name(), parts[a].name, of_b.channel.name(), parts[b].name,
                        size_text(cross.sigma, of_a.channel), column.channel.name(),
                        size_text(own.sigma, column.channel)));
      }
  }
  return {};
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double n = 0, mean_a = 0, mean_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!is_missing(a[i])) n += 1, mean_a += a[i], mean_b += b[i];
  if (n < static_cast<double>(kFewRows)) return 0;
  mean_a /= n, mean_b /= n;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!is_missing(a[i])) {
      aa += (a[i] - mean_a) * (a[i] - mean_a);
      bb += (b[i] - mean_b) * (b[i] - mean_b);
      ab += (a[i] - mean_a) * (b[i] - mean_b);
    }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

// Wanted poses say which way each length must go.
Result<void> check_targets(const JoinPart& part) {
  if (!part.trajectory) return {};
  const auto& coordinates = part.trajectory->coordinates;
  const auto target = [&part](std::size_t coordinate) {
    std::vector<double> mm;
    for (std::size_t row = 0; row < part.data.rows; ++row) {
      const auto of = static_cast<std::size_t>(part.row_of(row));
      mm.push_back(of < part.trajectory->points.size()
                       ? part.trajectory->points[of].target[coordinate]
                       : 0.0);
    }
    return mm;
  };
  for (const auto& column : part.data.columns) {
    const auto own = std::ranges::find(coordinates, column.channel.symbol, &Channel::symbol);
    if (!is_pose_symbol(column.channel.symbol) || !is_length(column.channel.unit) ||
        own == coordinates.end())
      continue;
    const double with_own =
        correlation(column.values, target(static_cast<std::size_t>(own - coordinates.begin())));
    for (std::size_t other = 0; other < coordinates.size(); ++other) {
      const double with_other = correlation(column.values, target(other));
      if (with_own < 0.5 && with_other > 0.9)
        return swapped(
            fmt::format("{} of {} follows the wanted {} (correlation {:.3f}) and not "
                        "the wanted {} ({:.3f})",
                        column.channel.name(), part.name, coordinates[other].name(), with_other,
                        own->name(), with_own));
    }
  }
  return {};
}

// Values of one channel are the same in all matched rows; missing in both counts as the same.
bool is_same(const DatasetColumn& a, const DatasetColumn& b, const MatchedRows& rows,
             std::size_t part_a, std::size_t part_b) {
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    const double one = a.values[rows.index[part_a][k]], other = b.values[rows.index[part_b][k]];
    if (is_missing(one) != is_missing(other)) return false;
    if (!is_missing(one) && one != other) return false;
  }
  return true;
}

bool is_one_measurement(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                        std::size_t b) {
  bool pose = false;
  for (const auto& column : parts[a].data.columns) {
    const auto* other = parts[b].data.find(column.channel.symbol);
    if (other == nullptr) continue;
    if (other->channel != column.channel || !is_same(column, *other, rows, a, b)) return false;
    pose = pose || is_pose_symbol(column.channel.symbol);
  }
  return pose;
}
}  // namespace

JoinCheck difference_of(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                        std::size_t b, const Channel& of_a, const Channel& of_b) {
  JoinCheck check;
  check.first = parts[a].name;
  check.second = parts[b].name;
  const auto [off, row] = differences_of(parts, rows, a, b, of_a, of_b, 0);
  check.rows = off.size();
  if (off.empty()) return check;
  // Neither sigma jumps by chance where the differences lie at two places. The first counts a tenth
  // of rows that agree as scatter (returns, where both were set to zero), the second is a fifth too
  // large at two places.
  check.median = median_of(off);
  check.sigma = std::min(sigma_without_far_off(off), sigma_of_most(off));
  for (std::size_t k = 0; k < off.size(); ++k)
    if (const double away = std::abs(off[k] - check.median); k == 0 || away > check.largest) {
      check.largest = away;
      check.largest_row = row[k];
    }
  return check;
}

Result<void> check_measured_once(const JoinParts& parts, const MatchedRows& rows) {
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = a + 1; b < parts.size(); ++b)
      if (is_one_measurement(parts, rows, a, b))
        return fail(ErrorCode::invalid_argument, reasons::kNothingToJoin,
                    fmt::format("part {} ({}) and part {} ({}) are the same measurement: all {} "
                                "rows that both have are equal to the last digit. Name each "
                                "measurement once",
                                a + 1, parts[a].name, b + 1, parts[b].name, rows.row.size()));
  return {};
}

Result<void> check_rows_shifted(const JoinParts& parts, const MatchedRows& rows) {
  for (const auto& part : parts) DRIFTWISE_RETURN_IF_ERROR(check_own_rows(part));
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = a + 1; b < parts.size(); ++b)
      DRIFTWISE_RETURN_IF_ERROR(check_pair_shifted(parts, rows, a, b));
  return {};
}

Result<void> check_setups_swapped(const JoinParts& parts, const MatchedRows& rows) {
  for (const auto& part : parts) DRIFTWISE_RETURN_IF_ERROR(check_targets(part));
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = a + 1; b < parts.size(); ++b)
      DRIFTWISE_RETURN_IF_ERROR(check_pair_swapped(parts, rows, a, b));
  return {};
}

}  // namespace driftwise::correction
