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

}  // namespace driftwise
