#include "server/diagnosis/rows/missing_values.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <numeric>

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

// Rows of untimed data that have the value of every channel of an earlier row: no second
// measurement. Coarse readings may well agree in all, so that one channel must tell the others
// apart. Rows with a time each have their own.
std::vector<std::uint8_t> there_before(const Dataset& data) {
  constexpr double kTellsApart = 0.9;  // of the different rows
  std::vector<std::uint8_t> repeats(data.rows, 0);
  if (!data.time_s.empty()) return repeats;
  std::vector<std::size_t> order(data.rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto compared = [&data](std::size_t a, std::size_t b) {
    for (const auto& column : data.columns) {
      const auto order_of_values = std::strong_order(column.values[a], column.values[b]);
      if (order_of_values != 0) return order_of_values;
    }
    return std::strong_ordering::equal;
  };
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return compared(a, b) == std::strong_ordering::less;
  });
  std::size_t different = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    repeats[order[i]] = i > 0 && compared(order[i - 1], order[i]) == 0 ? 1 : 0;
    different += repeats[order[i]] == 0 ? 1 : 0;
  }
  const bool told_apart =
      std::ranges::any_of(data.columns, [different](const DatasetColumn& column) {
        auto values = column.values;
        std::ranges::sort(values, [](double a, double b) { return std::strong_order(a, b) < 0; });
        return static_cast<double>(std::ranges::unique(values).begin() - values.begin()) >=
               kTellsApart * static_cast<double>(different);
      });
  if (!told_apart) std::ranges::fill(repeats, 0);
  return repeats;
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
  std::vector<std::uint8_t> gone = there_before(data);
  const auto repeated = static_cast<std::size_t>(std::ranges::count(gone, 1));
  if (repeated > 0)
    result.sentences.push_back(rows_text(repeated, data.rows) +
                               " repeat an earlier row in every value and were left out");
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
