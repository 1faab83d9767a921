#include "server/formats/import/row_order.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

namespace {

constexpr std::int64_t kHour_ns = 3'600'000'000'000, kHalf_ns = kHour_ns / 2;
constexpr std::int64_t kMinute_ns = kHour_ns / 60;

// Rows from one on, up to another: they run on but for late ones.
struct Block {
  CellTime first, last;
};

}  // namespace

// Steps of the file beyond its latest stamp so far: a late row's step back, and the one that
// catches up, are none.
std::vector<std::int64_t> RowTimes::forward_steps_ns() const {
  std::vector<std::int64_t> steps;
  if (rows_.empty()) return steps;
  CellTime latest = rows_.front().time;
  for (const Row& row : rows_) {
    if (row.time > latest) steps.push_back((row.time - latest).count());
    latest = std::max(latest, row.time);
  }
  return steps;
}

// Rows before which local time may have gone back by the hour of summer time, or half of it. Such a
// stamp is behind the one before by that hour less the time between the two rows, which is known by
// the other steps alone: rows of 45 min step back by 15, rows of an hour repeat a stamp. Each step
// is judged by itself: a clock that was set right, or a late row, elsewhere in the file excuses
// none. No calendar is asked: clocks are set back in any month (Casablanca in February). Of several
// steps those count after which the clock runs through times that it had before. Series that were
// joined out of order step back as well, and have no times in common.
std::vector<std::size_t> RowTimes::rows_of_clock_set_back() const {
  std::vector<std::size_t> found, same, begins{0};
  auto steps_ns = forward_steps_ns();
  if (steps_ns.empty()) return found;
  std::ranges::sort(steps_ns);
  const std::int64_t smallest_ns = steps_ns.front(), largest_ns = steps_ns.back();
  const std::int64_t median_ns = steps_ns[steps_ns.size() / 2];
  std::size_t steps_back = 0;
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    const std::int64_t back_ns = (rows_[i - 1].time - rows_[i].time).count();
    const bool local = rows_[i].local && rows_[i - 1].local;
    steps_back += back_ns > 0;
    if (local && back_ns == 0) same.push_back(i);
    if (back_ns <= 0) continue;
    // Less than a minute is left of the hour after a pause of just that length: too rare to refuse
    // late rows of every file with a pause, unless its rows are that far apart as a rule.
    const std::int64_t between_ns = back_ns < kMinute_ns ? median_ns : largest_ns;
    if (back_ns + between_ns < kHalf_ns) continue;
    begins.push_back(i);
    if (local && back_ns <= kHour_ns) found.push_back(i);
  }
  if (steps_back > 1) {
    std::vector<Block> blocks;
    for (std::size_t k = 0; k < begins.size(); ++k) {
      const std::size_t end = k + 1 < begins.size() ? begins[k + 1] : rows_.size();
      const auto [first, last] =
          std::ranges::minmax(std::span(rows_).subspan(begins[k], end - begins[k]), {}, &Row::time);
      blocks.push_back({first.time, last.time});
    }
    std::erase_if(found, [&](std::size_t row) {
      const auto k = std::ranges::lower_bound(begins, row) - begins.begin();
      const auto after = static_cast<std::size_t>(k);
      return blocks[after].last <= blocks[after - 1].first;
    });
  }
  // Rows of one stamp are common where the stamps are coarser than the rows, and only there.
  if (same.size() == 1 && smallest_ns >= kHalf_ns) found.push_back(same.front());
  std::ranges::sort(found);
  return found;
}

Result<RowTimes::Ordered> RowTimes::put_in_order(const TimeRules& rules,
                                                 const std::string& file_name) const {
  if (const auto back = rows_of_clock_set_back(); !back.empty()) {
    const Row &row = rows_[back.front()], &before = rows_[back.front() - 1];
    return fail(
        ErrorCode::invalid_argument, reasons::kTimeNotIncreasing,
        at_line(file_name, row.line) + "found the time " + to_iso8601(row.time) + " after " +
            to_iso8601(before.time) + " in line " + std::to_string(before.line) + ", " +
            (back.size() == 1 ? "the one such step"
                              : "the first of " + std::to_string(back.size()) + " such steps") +
            " in the file, by stamps without a zone: the clock may have been set "
            "back here (summer time?). Split the file before this line and import the "
            "first part with the utc_offset_h of summer, the second with one hour less (2 "
            "and 1 in central Europe); sorting or parting these rows would mix two hours. "
            "If the clock kept one time, write its zone behind the stamps (+01:00)");
  }
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
