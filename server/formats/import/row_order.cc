#include "server/formats/import/row_order.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

// The first row after local time went back by the hour of summer time, or half of it: the only step
// back of the file, by 30 to 60 min less the step between two rows, in the middle of rows that go
// on increasing on both sides and past it.
std::optional<std::size_t> RowTimes::row_of_clock_set_back() const {
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  std::optional<std::size_t> at;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!rows_[i].local) return std::nullopt;
    if (i == 0 || rows_[i].time >= rows_[i - 1].time) continue;
    if (at) return std::nullopt;
    at = i;
  }
  if (!at || *at < 2 || *at + 1 >= rows_.size()) return std::nullopt;
  const auto time = [this](std::size_t row) { return rows_[row].time; };
  const std::int64_t back_ns = (time(*at - 1) - time(*at)).count();
  const bool rows_on_both_sides = time(*at - 2) > time(*at) && time(*at + 1) < time(*at - 1);
  if (back_ns < 30 * kMinute_ns || back_ns > 60 * kMinute_ns || !rows_on_both_sides ||
      rows_.back().time <= time(*at - 1))
    return std::nullopt;
  return at;
}

Result<RowTimes::Ordered> RowTimes::put_in_order(const TimeRules& rules,
                                                 const std::string& file_name) const {
  if (const auto at = row_of_clock_set_back())
    return fail(ErrorCode::invalid_argument, reasons::kTimeNotIncreasing,
                at_line(file_name, rows_[*at].line) + "found the time " +
                    to_iso8601(rows_[*at].time) + " after " + to_iso8601(rows_[*at - 1].time) +
                    " in line " + std::to_string(rows_[*at - 1].line) +
                    ", once in the file, by stamps without a zone: the clock was set back here "
                    "(summer time?). Split the file before this line and import the first part "
                    "with the utc_offset_h of summer, the second with one hour less (2 and 1 in "
                    "central Europe); sorting would mix the two hours");
  Ordered out;
  out.rows.resize(rows_.size());
  std::iota(out.rows.begin(), out.rows.end(), std::size_t{0});
  if (rules.order == RowOrder::by_time) {
    std::ranges::stable_sort(out.rows, {}, [&](std::size_t row) { return rows_[row].time; });
    CellTime latest{std::numeric_limits<std::int64_t>::min()};
    for (const Row& row : rows_) {
      out.late += row.time < latest;
      latest = std::max(latest, row.time);
    }
  }
  // Divided, not multiplied by 1e-9: whole seconds stay whole.
  const auto seconds_after_zero = [&](const Row& row) {
    return static_cast<double>((row.time - out.zero).count()) / 1e9;
  };
  const auto refuse = [&](const Row& row, const Row& before, const std::string& advice) {
    return fail(ErrorCode::invalid_argument, reasons::kTimeNotIncreasing,
                at_line(file_name, row.line) + "found the time " + to_iso8601(row.time) +
                    " after " + to_iso8601(before.time) + " in line " +
                    std::to_string(before.line) + ", expected a later one: " + advice);
  };
  if (rules.format.has_epoch()) out.zero = rows_[out.rows.front()].time;
  for (std::size_t i = 0; i < out.rows.size();) {
    const Row& row = rows_[out.rows[i]];
    if (i > 0 && row.time < rows_[out.rows[i - 1]].time)
      return refuse(row, rows_[out.rows[i - 1]], "time.order = \"by-time\" sorts the rows");
    std::size_t same = 1;
    while (i + same < out.rows.size() && rows_[out.rows[i + same]].time == row.time) ++same;
    if (same > 1 && rules.equal == EqualTimes::refuse)
      return refuse(rows_[out.rows[i + 1]], row,
                    "time.equal_times = \"spread\" parts the rows of one stamp within "
                    "time.resolution_s");
    out.spread += same - 1;
    for (std::size_t k = 0; k < same; ++k)
      out.time_s.push_back(seconds_after_zero(row) +
                           rules.resolution_s * static_cast<double>(k) / static_cast<double>(same));
    i += same;
  }
  for (std::size_t i = 1; i < out.time_s.size(); ++i)
    if (!(out.time_s[i] > out.time_s[i - 1]))
      return refuse(rows_[out.rows[i]], rows_[out.rows[i - 1]],
                    "time.resolution_s is wider than the step between the stamps");
  return out;
}

}  // namespace driftwise::formats
