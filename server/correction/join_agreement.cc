#include "server/correction/join_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

constexpr double kSameTarget_mm = 1e-9;  // a trajectory is the same text; 1 fm is its last digit

tl::unexpected<Error> trajectories_differ(const std::string& sentence) {
  return fail(ErrorCode::failed_precondition, reasons::kTrajectoriesDiffer,
              sentence + ": join runs of one trajectory only");
}

std::string names_of_channels(const std::vector<Channel>& channels) {
  std::string text;
  for (const auto& channel : channels) text += (text.empty() ? "" : ", ") + channel.name();
  return text;
}

Result<void> compare_points(const JoinPart& a, const JoinPart& b, std::size_t row) {
  const auto& first = a.trajectory->points[row];
  const auto& second = b.trajectory->points[row];
  const auto differ = [&](const std::string& what, const std::string& in_a,
                          const std::string& in_b) {
    return trajectories_differ(fmt::format("row {}: {} is {} in {} and {} in {}", row + 1, what,
                                           in_a, a.name, in_b, b.name));
  };
  for (std::size_t i = 0; i < first.target.size(); ++i)
    if (!(std::abs(first.target[i] - second.target[i]) <= kSameTarget_mm))
      return differ(a.trajectory->coordinates[i].name(), number_text(first.target[i]),
                    number_text(second.target[i]));
  if (first.zero != second.zero)
    return differ("zero", first.zero ? "1" : "0", second.zero ? "1" : "0");
  if (first.set != second.set) {
    const auto word = [](PointSet set) {
      return set == PointSet::calibration ? "calibration" : "validation";
    };
    return differ("set", word(first.set), word(second.set));
  }
  if (first.force_n.value_or(0) != second.force_n.value_or(0))
    return differ("force_N", number_text(first.force_n.value_or(0)),
                  number_text(second.force_n.value_or(0)));
  return {};
}

Result<void> compare_trajectories(const JoinPart& a, const JoinPart& b) {
  if (a.trajectory->coordinates != b.trajectory->coordinates)
    return trajectories_differ(fmt::format("row 1: {} moves {} and {} moves {}", a.name,
                                           names_of_channels(a.trajectory->coordinates), b.name,
                                           names_of_channels(b.trajectory->coordinates)));
  const std::size_t common = std::min(a.trajectory->points.size(), b.trajectory->points.size());
  for (std::size_t row = 0; row < common; ++row)
    DRIFTWISE_RETURN_IF_ERROR(compare_points(a, b, row));
  if (a.trajectory->points.size() != b.trajectory->points.size())
    return trajectories_differ(fmt::format("row {}: {} has {} rows and {} has {}", common + 1,
                                           a.name, a.trajectory->points.size(), b.name,
                                           b.trajectory->points.size()));
  return {};
}

// Index in b's data of each row of a's; b.data.rows: none.
std::vector<std::size_t> matching_rows(const JoinPart& a, const JoinPart& b) {
  std::vector<std::pair<std::int64_t, std::size_t>> of_b;
  for (std::size_t i = 0; i < b.data.rows; ++i) of_b.emplace_back(b.row_of(i), i);
  std::ranges::sort(of_b);
  std::vector<std::size_t> match(a.data.rows, b.data.rows);
  for (std::size_t i = 0; i < a.data.rows; ++i) {
    const auto found = std::ranges::lower_bound(of_b, a.row_of(i), {},
                                                &std::pair<std::int64_t, std::size_t>::first);
    if (found != of_b.end() && found->first == a.row_of(i)) match[i] = found->second;
  }
  return match;
}

double mm_per_unit(const Channel& channel) { return mm_from_nm(summary_unit(channel.unit).factor); }

// Without trajectories: by where the motors were.
Result<void> compare_motion(const JoinPart& a, const JoinPart& b, const JoinRules& rules) {
  const auto match = matching_rows(a, b);
  for (std::size_t i = 0; i < a.data.rows; ++i) {
    if (match[i] == b.data.rows) continue;
    for (const auto& column : a.data.columns) {
      if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit)) continue;
      const auto* other = b.data.find(column.channel.symbol);
      if (other == nullptr || other->channel != column.channel) continue;
      const double mm = mm_per_unit(column.channel) * (column.values[i] - other->values[match[i]]);
      if (std::abs(mm) > rules.max_zero_difference_mm)
        return trajectories_differ(
            fmt::format("row {}: {} is {} in {} and {} in {}, more than {} apart", a.row_of(i) + 1,
                        column.channel.name(), number_text(column.values[i]), a.name,
                        number_text(other->values[match[i]]), b.name,
                        quantity_text(nm_from_mm(rules.max_zero_difference_mm), "nm")));
    }
    const auto zero_of = [](const Dataset& data, std::size_t row) {
      return !data.zero.empty() && data.zero[row] != 0;
    };
    if (!a.data.zero.empty() && !b.data.zero.empty() &&
        zero_of(a.data, i) != zero_of(b.data, match[i]))
      return trajectories_differ(fmt::format("row {}: a return to zero in only one of {} and {}",
                                             a.row_of(i) + 1, a.name, b.name));
  }
  if (a.row.empty() && b.row.empty() && a.data.rows != b.data.rows)
    return trajectories_differ(fmt::format("row {}: {} has {} rows and {} has {}",
                                           std::min(a.data.rows, b.data.rows) + 1, a.name,
                                           a.data.rows, b.name, b.data.rows));
  return {};
}

Result<void> check_tools(const JoinParts& parts, JoinReport& report) {
  const JoinPart* said = nullptr;
  for (const auto& part : parts) {
    if (part.tool.empty()) continue;
    if (said && said->tool != part.tool)
      return fail(ErrorCode::failed_precondition, reasons::kToolsDiffer,
                  fmt::format("{} was measured with tool {} and {} with tool {}: join runs with "
                              "one tool only",
                              said->name, shown(said->tool), part.name, shown(part.tool)));
    said = &part;
  }
  if (said)
    for (const auto& part : parts)
      if (part.tool.empty())
        report.warnings.push_back(fmt::format("tool of {} is not stated, {} has {}", part.name,
                                              said->name, shown(said->tool)));
  return {};
}

void check_models(const JoinParts& parts, JoinReport& report) {
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].model == parts[0].model) continue;
    double largest_mm = 0;
    const auto match = matching_rows(parts[0], parts[i]);
    for (const auto& column : parts[0].data.columns) {
      const auto* other = parts[i].data.find(column.channel.symbol);
      if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit) || !other)
        continue;
      for (std::size_t row = 0; row < match.size(); ++row)
        if (match[row] != parts[i].data.rows)
          largest_mm =
              std::max(largest_mm, mm_per_unit(column.channel) *
                                       std::abs(column.values[row] - other->values[match[row]]));
    }
    const auto word = [](const std::string& model) { return model.empty() ? "no model" : model; };
    report.warnings.push_back(
        fmt::format("{} was moved by {} and {} by {}: motor coordinates differ by up to {}",
                    parts[0].name, word(parts[0].model), parts[i].name, word(parts[i].model),
                    quantity_text(nm_from_mm(largest_mm), "nm")));
  }
}

// Structure temperatures at the datum, by symbol.
std::vector<ChannelValue> datum_temperatures(const JoinPart& part, std::size_t zero_row) {
  if (!part.datum.empty()) return part.datum;
  std::vector<ChannelValue> values;
  for (const auto& column : part.data.columns)
    if (is_structure_temperature(column.channel) && !is_missing(column.values[zero_row]))
      values.push_back({column.channel.name(), column.values[zero_row]});
  return values;
}

Result<void> check_temperatures(const JoinParts& parts, const JoinRules& rules,
                                const std::vector<std::vector<std::size_t>>& zeros,
                                JoinReport& report) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      const auto first = datum_temperatures(parts[i], zeros[i].front());
      const auto second = datum_temperatures(parts[j], zeros[j].front());
      for (const auto& value : first) {
        const auto other = std::ranges::find(second, value.channel, &ChannelValue::channel);
        if (other == second.end()) continue;
        const double kelvin = std::abs(value.value - other->value);
        if (kelvin > report.temperature_difference_k.value_or(-1)) {
          report.temperature_difference_k = kelvin;
          report.temperature_channel = value.channel;
        }
        if (kelvin > rules.max_temperature_difference_k)
          return fail(
              ErrorCode::failed_precondition, reasons::kTemperaturesDiffer,
              fmt::format("{} was {:.3f} degC at the datum of {} and {:.3f} degC at that of {}: "
                          "{:.3f} K apart, limit {:g} K. Measure again at the same temperature, "
                          "or state a wider limit",
                          value.channel, value.value, parts[i].name, other->value, parts[j].name,
                          kelvin, rules.max_temperature_difference_k));
      }
    }
  return {};
}

Result<void> check_zeros(const JoinParts& parts, const JoinRules& rules,
                         const std::vector<std::vector<std::size_t>>& zeros, JoinReport& report) {
  for (const auto& column : parts[0].data.columns) {
    if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit)) continue;
    double first_mm = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto* other = parts[i].data.find(column.channel.symbol);
      if (other == nullptr) continue;
      std::vector<double> at_zero;
      for (const auto row : zeros[i])
        if (!is_missing(other->values[row]))
          at_zero.push_back(mm_per_unit(other->channel) * other->values[row]);
      const double mm = median_of(at_zero);
      if (i == 0) first_mm = mm;
      const double apart = std::abs(mm - first_mm);
      report.zero_difference_mm = std::max(report.zero_difference_mm.value_or(0), apart);
      if (apart > rules.max_zero_difference_mm)
        return fail(
            ErrorCode::failed_precondition, reasons::kZerosDiffer,
            fmt::format("{} at pose zero is {} mm in {} and {} mm in {}: {} apart, limit "
                        "{}. Home the robot as before and measure again, or state a "
                        "wider limit",
                        column.channel.symbol, number_text(first_mm), parts[0].name,
                        number_text(mm), parts[i].name, quantity_text(nm_from_mm(apart), "nm"),
                        quantity_text(nm_from_mm(rules.max_zero_difference_mm), "nm")));
    }
  }
  return {};
}

}  // namespace

std::string names_of(const JoinParts& parts) {
  std::string names;
  for (const auto& part : parts) names += (names.empty() ? "" : ", ") + part.name;
  return names;
}

std::vector<std::size_t> rows_at_zero(const JoinPart& part, const JoinRules& rules) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < part.data.rows; ++row)
    if (!part.data.zero.empty() && part.data.zero[row] != 0) rows.push_back(row);
  if (!rows.empty()) return rows;
  const auto is_there = [&](std::size_t row) {
    bool any = false;
    for (const auto& column : part.data.columns) {
      if (!is_motor_symbol(column.channel.symbol) || !is_length(column.channel.unit)) continue;
      if (!(std::abs(mm_per_unit(column.channel) * column.values[row]) <=
            rules.max_zero_difference_mm))
        return false;
      any = true;
    }
    return any;
  };
  for (std::size_t row = 0; row < part.data.rows; ++row)
    if (is_there(row)) rows.push_back(row);
  return rows;
}

Result<void> check_trajectories(const JoinParts& parts, const JoinRules& rules) {
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[0].trajectory && parts[i].trajectory)
      DRIFTWISE_RETURN_IF_ERROR(compare_trajectories(parts[0], parts[i]));
    else
      DRIFTWISE_RETURN_IF_ERROR(compare_motion(parts[0], parts[i], rules));
  }
  return {};
}

Result<void> check_conditions(const JoinParts& parts, const JoinRules& rules, JoinReport& report) {
  std::vector<std::vector<std::size_t>> zeros;
  for (const auto& part : parts) {
    zeros.push_back(rows_at_zero(part, rules));
    if (zeros.back().empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoPoseZero,
                  fmt::format("{} has no row at pose zero: zeros are aligned there, so the "
                              "trajectory needs a return to zero (zero = 1)",
                              part.name));
  }
  DRIFTWISE_RETURN_IF_ERROR(check_tools(parts, report));
  DRIFTWISE_RETURN_IF_ERROR(check_temperatures(parts, rules, zeros, report));
  DRIFTWISE_RETURN_IF_ERROR(check_zeros(parts, rules, zeros, report));
  check_models(parts, report);
  return {};
}

}  // namespace driftwise::correction
