#include "server/core/data/row_marks.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

namespace driftwise {
namespace {

template <class T>
void keep(std::vector<T>& values, const std::vector<std::size_t>& rows) {
  if (values.empty()) return;
  std::vector<T> kept;
  kept.reserve(rows.size());
  for (const std::size_t row : rows) kept.push_back(values[row]);
  values = std::move(kept);
}

void keep_rows(Dataset& dataset, const std::vector<std::size_t>& rows) {
  keep(dataset.time_s, rows);
  keep(dataset.set, rows);
  keep(dataset.line, rows);
  keep(dataset.zero, rows);
  keep(dataset.dwell_s, rows);
  keep(dataset.run, rows);
  keep(dataset.datum, rows);
  keep(dataset.excluded, rows);
  for (auto& column : dataset.columns) keep(column.values, rows);
  dataset.rows = rows.size();
}

}  // namespace

std::size_t count_kept_out(const Dataset& dataset) {
  return static_cast<std::size_t>(std::ranges::count_if(
      dataset.excluded, [](auto mark) { return mark != kInUse && mark != kPassageRow; }));
}

std::size_t count_rows_of_plan(const Dataset& dataset) {
  return dataset.rows - static_cast<std::size_t>(std::ranges::count(dataset.excluded, kPassageRow));
}

void leave_excluded_out(Dataset& dataset) {
  if (dataset.excluded.empty()) return;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!dataset.is_excluded(row)) rows.push_back(row);
  keep_rows(dataset, rows);
  dataset.excluded.clear();
}

std::vector<std::size_t> leave_passages_out(Dataset& dataset) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!is_passage(dataset, row)) rows.push_back(row);
  if (rows.size() == dataset.rows) return rows;
  keep_rows(dataset, rows);
  if (std::ranges::count(dataset.excluded, kInUse) == std::ssize(dataset.excluded))
    dataset.excluded.clear();
  return rows;
}

std::size_t end_of_first_rows(const Dataset& dataset, std::size_t count) {
  if (dataset.excluded.empty()) return std::min(count, dataset.rows);
  std::size_t end = 0;
  for (std::size_t seen = 0; end < dataset.rows && seen < count; ++end)
    if (!is_passage(dataset, end)) ++seen;
  return end;
}

}  // namespace driftwise
