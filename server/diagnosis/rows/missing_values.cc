#include "server/diagnosis/rows/missing_values.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <numeric>

#include "server/effects/term_order.h"

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

// Number of values that were set: a gap as a whole or not at all. Before the first reading and
// after the last one the nearest holds.
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
  if (clock[present.front()] - clock.front() <= longest)
    for (std::size_t row = 0; row < present.front(); ++row) set(row, values[present.front()]);
  if (clock.back() - clock[present.back()] <= longest)
    for (std::size_t row = present.back() + 1; row < values.size(); ++row)
      set(row, values[present.back()]);
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
// apart.
std::vector<std::uint8_t> there_before(const Dataset& data) {
  constexpr double kTellsApart = 0.9;  // of the different rows
  std::vector<std::uint8_t> repeats(data.rows, 0);
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

// Rows of timed data that have the value of every channel of the row before: a logger that polls
// faster than the instruments read. Two channels must tell the different rows apart, for a coarse
// display that stands still agrees with itself by chance.
std::vector<std::uint8_t> polled_again(const Dataset& data) {
  constexpr double kTellsApart = 0.9;  // of the different rows
  std::vector<std::uint8_t> repeats(data.rows, 0);
  std::size_t different = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    const bool again =
        row > 0 && std::ranges::all_of(data.columns, [row](const DatasetColumn& column) {
          return std::strong_order(column.values[row - 1], column.values[row]) == 0;
        });
    repeats[row] = again ? 1 : 0;
    different += again ? 0 : 1;
  }
  const auto apart = std::ranges::count_if(data.columns, [&](const DatasetColumn& column) {
    std::vector<double> values;
    for (const double value : column.values)
      if (std::isfinite(value)) values.push_back(value);
    std::ranges::sort(values);
    return static_cast<double>(std::ranges::unique(values).begin() - values.begin()) >=
           kTellsApart * static_cast<double>(different);
  });
  if (apart < 2) std::ranges::fill(repeats, 0);
  return repeats;
}

// Closes what can be closed and excludes the rows that still lack a value, within kMostRows: of
// the channels that few rows lack first, for each may add rows until too many would go. Rows that
// are excluded already lack nothing. read: symbols of the baseline, whose rows go by themselves.
void leave_out_lacking(const std::vector<std::string>& conditions,
                       const std::vector<std::string>& read, WithoutGaps& whole) {
  Dataset& data = whole.data;
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
        whole.sentences.push_back(
            rows_text(closed, data.rows) + " have no value of " + channel.symbol +
            ": taken from the readings before and after, along a straight line in time");
    if (std::ranges::find(read, channel.symbol) != read.end() ||
        std::ranges::none_of(column.values, [](double value) { return std::isfinite(value); }))
      continue;
    Lacking one{channel.symbol, {}};
    for (std::size_t row = 0; row < data.rows; ++row)
      if (!std::isfinite(column.values[row]) && !data.is_excluded(row)) one.rows.push_back(row);
    if (!one.rows.empty()) lacking.push_back(std::move(one));
  }
  std::ranges::stable_sort(lacking, {}, [](const Lacking& one) { return one.rows.size(); });
  for (const auto& one : lacking) {
    const auto more = static_cast<std::size_t>(std::ranges::count_if(
        one.rows, [&data](std::size_t row) { return !data.is_excluded(row); }));
    if (static_cast<double>(whole.left_out + more) > kMostRows * static_cast<double>(data.rows)) {
      whole.unread.push_back(one.symbol);
      whole.sentences.push_back(rows_text(one.rows.size(), data.rows) + " have no value of " +
                                one.symbol + ": no cause that reads it was tested");
      continue;
    }
    whole.left_out += more;
    if (data.excluded.empty()) data.excluded.assign(data.rows, 0);
    for (const std::size_t row : one.rows) data.excluded[row] = 1;
    whole.sentences.push_back(rows_text(one.rows.size(), data.rows) + " have no value of " +
                              one.symbol + " and were left out");
  }
}

}  // namespace

WithoutGaps without_gaps(Dataset data, const std::vector<std::string>& conditions) {
  WithoutGaps result{.data = std::move(data), .unread = {}, .sentences = {}, .left_out = 0};
  const bool timed = !result.data.time_s.empty();
  const auto repeats = timed ? polled_again(result.data) : there_before(result.data);
  if (const auto count = std::ranges::count(repeats, 1); count > 0) {
    auto& excluded = result.data.excluded;
    if (excluded.empty()) excluded.assign(result.data.rows, 0);
    for (std::size_t row = 0; row < repeats.size(); ++row) excluded[row] |= repeats[row];
    result.sentences.push_back(rows_text(static_cast<std::size_t>(count), result.data.rows) +
                               (timed ? " repeat the row before in every value: one reading, "
                                        "polled again; they were left out"
                                      : " repeat an earlier row in every value and were left out"));
  }
  leave_out_lacking(conditions, {}, result);
  return result;
}

void close_gaps_of(const std::vector<FaultySensor>& sensors, const LivingBaseline& living,
                   WithoutGaps& whole) {
  std::vector<std::string> blanked;
  for (const auto& sensor : sensors)
    if ((sensor.fault == SensorFault::frozen || sensor.fault == SensorFault::spiked) &&
        std::ranges::find(living.dead, sensor.channel) == living.dead.end())
      blanked.push_back(sensor.channel);
  std::vector<std::string> read;
  for (const auto& term : living.baseline.terms)
    for (auto& symbol : effects::symbols_of(term)) read.push_back(std::move(symbol));
  leave_out_lacking(blanked, read, whole);
}

}  // namespace driftwise::diagnosis
