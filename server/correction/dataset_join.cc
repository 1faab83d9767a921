#include "server/correction/dataset_join.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/correction/join_agreement.h"
#include "server/correction/join_angles.h"
#include "server/correction/join_lengths.h"
#include "server/correction/join_suspicion.h"
#include "server/correction/return_subtraction.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

MatchedRows matched(const JoinParts& parts) {
  std::map<std::int64_t, std::vector<std::size_t>> found;
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.data.rows; ++i) found[part.row_of(i)].push_back(i);
  MatchedRows rows;
  rows.index.resize(parts.size());
  for (const auto& [row, index] : found) {
    if (index.size() != parts.size()) continue;
    rows.row.push_back(row);
    for (std::size_t p = 0; p < parts.size(); ++p) rows.index[p].push_back(index[p]);
  }
  return rows;
}

std::size_t count_of_rows(const JoinParts& parts) {
  std::set<std::int64_t> all;
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.data.rows; ++i) all.insert(part.row_of(i));
  return all.size();
}

// Parts that measured a channel; errors where they give it in different units.
Result<std::vector<std::size_t>> sources_of(const JoinParts& parts, const Channel& channel) {
  std::vector<std::size_t> sources;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto* column = parts[p].data.find(channel.symbol);
    if (column == nullptr || !has_values(*column)) continue;
    if (column->channel != channel)
      return fail(
          ErrorCode::invalid_argument, reasons::kNothingToJoin,
          fmt::format("{} of {} is in {}, {} of another part in {}: give one unit", channel.symbol,
                      parts[p].name, column->channel.unit, channel.symbol, channel.unit));
    sources.push_back(p);
  }
  return sources;
}

// All channels, in the order of the parts.
std::vector<Channel> channels_of(const JoinParts& parts) {
  std::vector<Channel> channels;
  for (const auto& part : parts)
    for (const auto& column : part.data.columns)
      if (std::ranges::find(channels, column.channel.symbol, &Channel::symbol) == channels.end())
        channels.push_back(column.channel);
  return channels;
}

double mean_of(const JoinParts& parts, const MatchedRows& rows,
               const std::vector<std::size_t>& sources, const std::string& symbol, std::size_t k,
               bool of_squares) {
  double sum = 0, count = 0;
  for (const auto p : sources) {
    const double value = parts[p].data.find(symbol)->values[rows.index[p][k]];
    if (is_missing(value)) continue;
    sum += of_squares ? value * value : value;
    count += 1;
  }
  if (count == 0) return kMissing;
  return of_squares ? std::sqrt(sum / count) : sum / count;
}

// Sigma of a part's motor coordinates about their mean over the parts, mm; the worst motor.
double motors_off_mm(const JoinParts& parts, const MatchedRows& rows, std::size_t of_part) {
  double worst = 0;
  for (const auto& column : parts[of_part].data.columns) {
    if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit)) continue;
    const auto sources = sources_of(parts, column.channel);
    if (!sources || sources->size() < 2) continue;
    std::vector<double> off;
    for (std::size_t k = 0; k < rows.row.size(); ++k) {
      const double d = column.values[rows.index[of_part][k]] -
                       mean_of(parts, rows, *sources, column.channel.symbol, k, false);
      if (!is_missing(d)) off.push_back(mm_per_unit_of(column.channel) * d);
    }
    worst = std::max(worst, sigma_without_far_off(std::move(off)));
  }
  return worst;
}

template <class T>
std::vector<T> of_first(const std::vector<T>& values, const MatchedRows& rows,
                        const std::vector<std::size_t>& order) {
  std::vector<T> out;
  if (values.empty()) return out;
  for (const auto k : order) out.push_back(values[rows.index[0][k]]);
  return out;
}

std::size_t axis_of_symbol(const std::string& symbol) {
  return static_cast<std::size_t>(symbol.back() - 'x');
}

// Of a difference: its scatter and what it is off by on average.
double size_of(const JoinCheck& check) { return std::hypot(check.sigma, check.median); }

class Join {
 public:
  Join(JoinParts parts, const JoinRules& rules) : parts_(std::move(parts)), rules_(rules) {}

  Result<JoinedData> run() {
    DRIFTWISE_RETURN_IF_ERROR(check());
    DRIFTWISE_RETURN_IF_ERROR(take_zeros_off());
    DRIFTWISE_RETURN_IF_ERROR(check_rows_shifted(parts_, rows_));
    DRIFTWISE_RETURN_IF_ERROR(check_setups_swapped(parts_, rows_));
    warn_of_corrections();
    angles_ = angle_errors(parts_, rows_, rules_);
    warn_of_rolls();
    AngleU u_arcsec{};
    for (std::size_t i = 0; i < 3; ++i) {
      DRIFTWISE_TRY(const auto u, angle_u(kAngles[i]));
      u_arcsec[i] = u;
    }
    const auto corrected = correct_lengths(rows_, u_arcsec, parts_);
    u_of_angles_mm_ = corrected.u_mm;
    if (corrected.rows_without_angle > 0)
      out_.report.warnings.push_back(
          fmt::format("a rotation that corrects lengths is missing in {} of {} rows: these lengths "
                      "are missing there",
                      corrected.rows_without_angle, rows_.row.size()));
    DRIFTWISE_RETURN_IF_ERROR(fill_rows());
    return std::move(out_);
  }

 private:
  Result<void> check() {
    if (parts_.size() < 2)
      return fail(ErrorCode::invalid_argument, reasons::kNothingToJoin,
                  fmt::format("found {} to join, expected two runs or files at least",
                              parts_.empty() ? "nothing" : parts_[0].name));
    for (const auto& part : parts_)
      if (std::ranges::none_of(part.data.columns, [](const DatasetColumn& column) {
            return is_pose_symbol(column.channel.symbol) && has_values(column);
          }))
        return fail(ErrorCode::invalid_argument, reasons::kNothingToJoin,
                    fmt::format("{} measured no pose coordinate (x, y, z, rx, ry, rz): leave it "
                                "out",
                                part.name));
    DRIFTWISE_RETURN_IF_ERROR(check_trajectories(parts_, rules_));
    rows_ = matched(parts_);
    const std::size_t all = count_of_rows(parts_);
    out_.report.unmatched_rows = all - rows_.row.size();
    if (rows_.row.size() < 2 || 2 * rows_.row.size() < all)
      return fail(ErrorCode::invalid_argument, reasons::kNoCommonRows,
                  fmt::format("{} of {} rows are in all of {}: a join needs half of them at least",
                              rows_.row.size(), all, names_of(parts_)));
    DRIFTWISE_RETURN_IF_ERROR(check_measured_once(parts_, rows_));
    return check_conditions(parts_, rules_, out_.report);
  }

  Result<void> take_zeros_off() {
    for (auto& part : parts_) {
      const auto zeros = rows_at_zero(part, rules_);
      scatter_.push_back(rules_.subtract_returns ? scatter_of_returns(part, zeros)
                                                 : spread_of_returns(part, zeros));
      if (rules_.subtract_returns)
        DRIFTWISE_RETURN_IF_ERROR(subtract_returns(zeros, part));
      else
        align_zeros(zeros, part);
    }
    return {};
  }

  // A stage corrects a length by angles; without one the angles of another run change nothing.
  void warn_of_corrections() {
    std::string without;
    for (const auto& part : parts_) {
      const bool has_length = std::ranges::any_of(kLengths, [&part](const char* length) {
        const auto* column = part.data.find(length);
        return column && has_values(*column);
      });
      if (has_length && !part.stage) without += (without.empty() ? "" : ", ") + part.name;
    }
    if (!without.empty())
      out_.report.warnings.push_back(
          "lengths of " + without +
          " are not corrected by the angles of the other runs: no [correction] is stated");
  }

  // A roll that is beyond its own uncertainty: its error is in u and can be taken out by a person.
  void warn_of_rolls() {
    constexpr double kTimes = 3, kMradPerRad = 1e3;
    for (const auto& roll : angles_.rolls)
      if (std::abs(roll.rad) > kTimes * roll.u_rad)
        out_.report.warnings.push_back(fmt::format(
            "autocollimator of {} is turned about its beam by {:.1f} +- {:.1f} mrad, by the "
            "rotation that two runs measured: the error of its other rotation is in u. Align it, "
            "or correct its two channels by this angle",
            roll.part, kMradPerRad * roll.rad, kMradPerRad * roll.u_rad));
  }

  std::optional<JoinCheck> worst_check(const Channel& channel,
                                       const std::vector<std::size_t>& sources) const {
    std::optional<JoinCheck> worst;
    for (std::size_t i = 0; i < sources.size(); ++i)
      for (std::size_t j = i + 1; j < sources.size(); ++j) {
        auto check = difference_of(parts_, rows_, sources[i], sources[j], channel, channel);
        if (check.rows > 0 && (!worst || size_of(check) > size_of(*worst)))
          worst = std::move(check);
      }
    return worst;
  }

  // In the channel's unit: of the difference where several measured it, else of the returns. None:
  // too few returns to know it.
  std::optional<double> u_of(const Channel& channel, const std::vector<std::size_t>& sources,
                             const std::optional<JoinCheck>& check) const {
    const auto m = static_cast<double>(sources.size());
    double square = 0;
    if (check) {
      square = size_of(*check) * size_of(*check) / 2 / m;
    } else {
      const auto& scatter = scatter_[sources.front()];
      const auto found = scatter.find(channel.name());
      if (found == scatter.end()) return std::nullopt;
      square = found->second * found->second;
    }
    if (const auto& seen = is_angle(channel.unit) ? angles_.square[axis_of_symbol(channel.symbol)]
                                                  : std::nullopt) {
      const double of_angles = *seen / std::pow(arcsec_per_unit(channel), 2);
      square = check ? of_angles : square + of_angles;
    }
    if (is_length(channel.unit)) {
      double off_mm = 0;
      for (const auto p : sources) off_mm = std::max(off_mm, motors_off_mm(parts_, rows_, p));
      const double of_angles_mm = u_of_angles_mm_[axis_of_symbol(channel.symbol)];
      const double unit = mm_per_unit_of(channel);
      square += (off_mm * off_mm + of_angles_mm * of_angles_mm) / unit / unit;
    }
    return std::sqrt(square);
  }

  void warn_of_unknown(const Channel& channel, const std::vector<std::size_t>& sources) {
    out_.report.warnings.push_back(fmt::format(
        "{}: the uncertainty of the join is not known{}: {} has {} in every datum; measure the "
        "zero more often",
        channel.name(),
        is_angle(channel.unit) ? ", nor its part in the lengths that it corrects" : "",
        parts_[sources.front()].name,
        rules_.subtract_returns ? "less than three returns to zero"
                                : "less than two returns to zero"));
  }

  Result<double> angle_u(const char* symbol) const {
    for (const auto& part : parts_) {
      const auto* column = part.data.find(symbol);
      if (column == nullptr || !has_values(*column)) continue;
      DRIFTWISE_TRY(const auto sources, sources_of(parts_, column->channel));
      return arcsec_per_unit(column->channel) *
             u_of(column->channel, sources, worst_check(column->channel, sources)).value_or(0);
    }
    return 0.0;
  }

  // Rows of the join in the time order of the first part.
  std::vector<std::size_t> order_of_rows() const {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < rows_.row.size(); ++k) {
      const auto& zero = parts_[0].data.zero;
      const bool is_zero = !zero.empty() && zero[rows_.index[0][k]] != 0;
      if (!(rules_.subtract_returns && is_zero)) order.push_back(k);
    }
    std::ranges::sort(order, {}, [this](std::size_t k) { return rows_.index[0][k]; });
    return order;
  }

  Result<void> fill_rows() {
    const auto order = order_of_rows();
    auto& data = out_.data;
    const auto& first = parts_[0].data;
    data.rows = out_.report.rows = order.size();
    for (const auto k : order) out_.rows.push_back(rows_.row[k]);
    data.time_s = of_first(first.time_s, rows_, order);
    data.set = of_first(first.set, rows_, order);
    data.line = of_first(first.line, rows_, order);
    data.zero = of_first(first.zero, rows_, order);
    data.dwell_s = of_first(first.dwell_s, rows_, order);
    data.datum = of_first(first.datum, rows_, order);
    fill_excluded(order);
    bool checked = false;
    for (const auto& channel : channels_of(parts_)) {
      DRIFTWISE_TRY(const auto sources, sources_of(parts_, channel));
      if (sources.empty()) continue;
      JoinedChannel joined{channel, {}, {}, worst_check(channel, sources)};
      for (const auto p : sources) joined.sources.push_back(parts_[p].name);
      if (is_pose_symbol(channel.symbol)) {
        joined.u = u_of(channel, sources, joined.check);
        if (!joined.u) warn_of_unknown(channel, sources);
        checked = checked || joined.check.has_value();
        warn_of_difference(channel, sources, joined.check);
      }
      DatasetColumn column{channel, {}};
      const bool is_spread = channel.symbol.ends_with("_std");
      for (const auto k : order)
        column.values.push_back(mean_of(parts_, rows_, sources, channel.symbol, k, is_spread));
      data.columns.push_back(std::move(column));
      out_.report.channels.push_back(std::move(joined));
    }
    if (!checked)
      out_.report.warnings.push_back(
          "no pose coordinate was measured in two runs: the join rests on the motor coordinates "
          "and on the returns to zero");
    if (out_.report.unmatched_rows > 0)
      out_.report.warnings.push_back(fmt::format("{} rows are left out: one of the runs lacks them",
                                                 out_.report.unmatched_rows));
    return {};
  }

  void fill_excluded(const std::vector<std::size_t>& order) {
    auto& data = out_.data;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const auto& excluded = parts_[p].data.excluded;
      if (excluded.empty()) continue;
      data.excluded.resize(data.rows, 0);
      for (std::size_t i = 0; i < order.size(); ++i)
        data.excluded[i] = std::max(data.excluded[i], excluded[rows_.index[p][order[i]]]);
    }
  }

  // A difference far beyond what the returns to zero of both runs explain.
  void warn_of_difference(const Channel& channel, const std::vector<std::size_t>& sources,
                          const std::optional<JoinCheck>& check) {
    constexpr double kTimes = 5;
    if (!check) return;
    double square = 0;
    for (const auto p : sources) {
      if (parts_[p].name != check->first && parts_[p].name != check->second) continue;
      if (const auto found = scatter_[p].find(channel.name()); found != scatter_[p].end())
        square += found->second * found->second;
    }
    const double expected = std::sqrt(square), size = size_of(*check);
    if (expected <= 0 || size <= kTimes * expected) return;
    const auto unit = summary_unit(channel.unit);
    out_.report.warnings.push_back(fmt::format(
        "{} of {} and {} differs by {} (median {}, sigma {}), {:.0f} times what their "
        "returns to zero say",
        channel.name(), check->first, check->second, quantity_text(unit.factor * size, unit.unit),
        quantity_text(unit.factor * check->median, unit.unit),
        quantity_text(unit.factor * check->sigma, unit.unit), size / expected));
  }

  JoinParts parts_;
  const JoinRules& rules_;
  MatchedRows rows_;
  std::vector<std::map<std::string, double>> scatter_;  // of one return, per part and channel
  AngleErrors angles_;
  std::array<double, 3> u_of_angles_mm_{};
  JoinedData out_;
};

}  // namespace

std::string measured_robot(const Dataset& data) {
  for (const auto& column : data.columns)
    if (is_pose_symbol(without_robot(column.channel.symbol)) && has_values(column))
      return std::string(robot_of(column.channel.symbol));
  return "";
}

// The join knows one robot, without an id: it is taken off before and put back after.
Result<JoinedData> join(JoinParts parts, const JoinRules& rules) {
  std::string robot;
  const JoinPart* of_robot = nullptr;
  std::set<std::string> bare;
  for (auto& part : parts) {
    const std::string own = measured_robot(part.data);
    if (own.empty()) continue;
    if (of_robot && own != robot)
      return fail(ErrorCode::invalid_argument, reasons::kNothingToJoin,
                  fmt::format("{} measured robot {} and {} robot {}: join the runs of one robot",
                              of_robot->name, robot, part.name, own));
    robot = own;
    of_robot = &part;
  }
  if (robot.empty()) return Join(std::move(parts), rules).run();
  for (auto& part : parts)
    for (auto& column : part.data.columns) {
      if (robot_of(column.channel.symbol) != robot) continue;
      column.channel.symbol = std::string(without_robot(column.channel.symbol));
      bare.insert(column.channel.symbol);
    }
  DRIFTWISE_TRY(auto joined, Join(std::move(parts), rules).run());
  const auto with_robot = [&](Channel& channel) {
    if (bare.contains(channel.symbol)) channel.symbol = robot + "." + channel.symbol;
  };
  for (auto& column : joined.data.columns) with_robot(column.channel);
  for (auto& channel : joined.report.channels) with_robot(channel.channel);
  return joined;
}

}  // namespace driftwise::correction
