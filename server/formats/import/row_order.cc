#include "server/formats/import/row_order.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

// The first row after local time went back by the hour of summer time, or half of it: the only step
// of the file that is not forward. Its stamp is behind the one before by that hour less the time
// between the two rows, which is known by the largest step of the others alone: rows of 45 min step
// back by 15, rows of an hour repeat a stamp.
std::optional<std::size_t> RowTimes::row_of_clock_set_back() const {
  constexpr std::int64_t kHour_ns = 3'600'000'000'000, kHalf_ns = kHour_ns / 2;
  std::vector<std::size_t> back, same;
  std::int64_t smallest_ns = std::numeric_limits<std::int64_t>::max(), largest_ns = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!rows_[i].local) return std::nullopt;
    if (i == 0) continue;
    const std::int64_t step_ns = (rows_[i].time - rows_[i - 1].time).count();
    if (step_ns < 0) back.push_back(i);
    if (step_ns == 0) same.push_back(i);
    if (step_ns > 0) smallest_ns = std::min(smallest_ns, step_ns);
    largest_ns = std::max(largest_ns, step_ns);
  }
  if (back.size() == 1) {
    const std::size_t at = back.front();
    const std::int64_t back_ns = (rows_[at - 1].time - rows_[at].time).count();
    if (back_ns <= kHour_ns && back_ns + largest_ns >= kHalf_ns) return at;
  }
  // Rows of one stamp are common where the stamps are coarser than the rows, and only there.
  const bool rare_rows = smallest_ns >= kHalf_ns && largest_ns > 0;
  if (back.empty() && same.size() == 1 && rare_rows) return same.front();
  return std::nullopt;
}

Result<RowTimes::Ordered> RowTimes::put_in_order(const TimeRules& rules,
                                                 const std::string& file_name) const {
  if (const auto at = row_of_clock_set_back())
    return fail(ErrorCode::invalid_argument, reasons::kTimeNotIncreasing,
                at_line(file_name, rows_[*at].line) + "found the time " +
                    to_iso8601(rows_[*at].time) + " after " + to_iso8601(rows_[*at - 1].time) +
                    " in line " + std::to_string(rows_[*at - 1].line) +
                    ", once in the file, by stamps without a zone: the clock may have been set "
                    "back here (summer time?). Split the file before this line and import the "
                    "first part with the utc_offset_h of summer, the second with one hour less (2 "
                    "and 1 in central Europe); sorting or parting these rows would mix two hours. "
                    "If the clock kept one time, write its zone behind the stamps (+01:00)");
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
