#include "server/diagnosis/rows/missing_values.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kMostOfTheTime = 0.05;  // that a gap may last
constexpr double kMostSteps = 3;         // the same, in usual distances of the channel's readings
constexpr double kMostRows = 0.2;        // that are left out for what they lack

bool changes_slowly(const Channel& channel) {
  return is_structure_temperature(channel) || channel.unit == "degC" || channel.unit == "hPa" ||
         channel.unit == "pct";
}

std::vector<double> clock_of(const Dataset& data) {
  if (!data.time_s.empty()) return data.time_s;
  std::vector<double> clock;
  for (std::size_t row = 0; row < data.rows; ++row) clock.push_back(static_cast<double>(row));
  return clock;
}

// Number of values that were set. Before the first reading and after the last one the nearest
// holds.
std::size_t close_gaps(const std::vector<double>& clock, std::vector<double>& values) {
  std::vector<std::size_t> present;
  for (std::size_t row = 0; row < values.size(); ++row)
    if (std::isfinite(values[row])) present.push_back(row);
  if (present.size() < 2 || present.size() == values.size()) return 0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < present.size(); ++i)
    steps.push_back(clock[present[i]] - clock[present[i - 1]]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  const double longest =
      std::max(kMostSteps * *middle, kMostOfTheTime * (clock.back() - clock.front()));
  std::size_t closed = 0;
  const auto set = [&](std::size_t row, double value) {
    values[row] = value;
    ++closed;
  };
  for (std::size_t row = 0; row < present.front(); ++row)
    if (clock[present.front()] - clock[row] <= longest) set(row, values[present.front()]);
  for (std::size_t row = present.back() + 1; row < values.size(); ++row)
    if (clock[row] - clock[present.back()] <= longest) set(row, values[present.back()]);
  for (std::size_t i = 1; i < present.size(); ++i) {
    const std::size_t from = present[i - 1], to = present[i];
    const double gap = clock[to] - clock[from];
    if (gap > longest) continue;
    for (std::size_t row = from + 1; row < to; ++row) {
      const double part = gap > 0 ? (clock[row] - clock[from]) / gap : 0.5;
      set(row, values[from] + part * (values[to] - values[from]));
    }
  }
  return closed;
}

std::string rows_text(std::size_t count, std::size_t rows) {
  return std::to_string(count) + " of " + std::to_string(rows) + " rows";
}

// The same instant and the same value of every channel as in the row before: no second measurement.
bool repeats_the_row_before(const Dataset& data, std::size_t row) {
  if (data.time_s.empty() || row == 0 || data.time_s[row] != data.time_s[row - 1]) return false;
  return std::ranges::all_of(data.columns, [row](const DatasetColumn& column) {
    const double before = column.values[row - 1], value = column.values[row];
    return value == before || (std::isnan(value) && std::isnan(before));
  });
}

}  // namespace

WithoutGaps without_gaps(Dataset data, const std::vector<std::string>& conditions) {
  WithoutGaps result;
  const std::vector<double> clock = clock_of(data);
  struct Lacking {
    std::string symbol;
    std::vector<std::size_t> rows;
  };
  std::vector<Lacking> lacking;
  for (auto& column : data.columns) {
    const Channel& channel = column.channel;
    if (std::ranges::find(conditions, channel.symbol) == conditions.end()) continue;
    if (changes_slowly(channel))
      if (const std::size_t closed = close_gaps(clock, column.values); closed > 0)
        result.sentences.push_back(
            rows_text(closed, data.rows) + " have no value of " + channel.symbol +
            ": taken from the readings before and after, along a straight line in time");
    Lacking one{channel.symbol, {}};
    for (std::size_t row = 0; row < data.rows; ++row)
      if (!std::isfinite(column.values[row])) one.rows.push_back(row);
    if (!one.rows.empty() && one.rows.size() < data.rows) lacking.push_back(std::move(one));
  }
  // Those that few rows lack first: each may add rows until too many would go.
  std::ranges::stable_sort(lacking, {}, [](const Lacking& one) { return one.rows.size(); });
  std::vector<std::uint8_t> gone(data.rows, 0);
  for (std::size_t row = 0; row < data.rows; ++row)
    gone[row] = repeats_the_row_before(data, row) ? 1 : 0;
  const auto repeated = static_cast<std::size_t>(std::ranges::count(gone, 1));
  if (repeated > 0)
    result.sentences.push_back(rows_text(repeated, data.rows) +
                               " repeat the row before in every value, its time included, and were "
                               "left out");
  for (const auto& one : lacking) {
    auto with = gone;
    for (const std::size_t row : one.rows) with[row] = 1;
    if (static_cast<double>(std::ranges::count(with, 1)) - static_cast<double>(repeated) >
        kMostRows * static_cast<double>(data.rows)) {
      result.unread.push_back(one.symbol);
      result.sentences.push_back(rows_text(one.rows.size(), data.rows) + " have no value of " +
                                 one.symbol + ": no cause that reads it was tested");
      continue;
    }
    gone = std::move(with);
    result.sentences.push_back(rows_text(one.rows.size(), data.rows) + " have no value of " +
                               one.symbol + " and were left out");
  }
  if (std::ranges::count(gone, 1) > 0) {
    if (data.excluded.empty()) data.excluded.assign(data.rows, 0);
    for (std::size_t row = 0; row < data.rows; ++row)
      if (gone[row] != 0) data.excluded[row] = 1;
  }
  result.data = std::move(data);
  return result;
}

}  // namespace driftwise::diagnosis
