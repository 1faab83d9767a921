#include "server/core/data/row_marks.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace driftwise {
namespace {

template <class T>
void keep_rows(std::vector<T>& values, const std::vector<std::size_t>& rows) {
  if (values.empty()) return;
  std::vector<T> kept;
  kept.reserve(rows.size());
  for (const std::size_t row : rows) kept.push_back(values[row]);
  values = std::move(kept);
}

}  // namespace

void leave_excluded_out(Dataset& dataset) {
  if (dataset.excluded.empty()) return;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!dataset.is_excluded(row)) rows.push_back(row);
  keep_rows(dataset.time_s, rows);
  keep_rows(dataset.set, rows);
  keep_rows(dataset.line, rows);
  keep_rows(dataset.zero, rows);
  keep_rows(dataset.dwell_s, rows);
  keep_rows(dataset.run, rows);
  keep_rows(dataset.datum, rows);
  for (auto& column : dataset.columns) keep_rows(column.values, rows);
  dataset.excluded.clear();
  dataset.rows = rows.size();
}

}  // namespace driftwise
