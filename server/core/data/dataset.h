#pragma once
// A table made of runs, or imported: one row per accepted point, in time order.
// Stored by columns; every column has one value per row, kMissing where nothing was measured.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/channel.h"
#include "server/core/data/reading.h"

namespace driftwise {

enum class PointSet : std::uint8_t { calibration, validation };

struct DatasetColumn {
  Channel channel;
  std::vector<double> values;
};

struct Dataset {
  std::vector<std::pair<std::string, std::string>>
      metadata;  // the leading "# key: value" lines, in order
  std::size_t rows = 0;

  // Empty when the file has no such column (all calibration; untimed; ...), else one entry per row.
  std::vector<double> time_s;
  std::vector<PointSet> set;
  std::vector<std::int64_t> line;
  std::vector<std::uint8_t> zero;
  std::vector<double> dwell_s;
  std::vector<std::int64_t> run;
  std::vector<std::int64_t> datum;
  // Above 0: kept out of fits (row_marks.h). Effects with memory still run over the row.
  std::vector<std::uint8_t> excluded;

  std::vector<DatasetColumn> columns;  // the channels, in file order

  const DatasetColumn* find(std::string_view symbol) const {
    for (const auto& column : columns)
      if (column.channel.symbol == symbol) return &column;
    return nullptr;
  }
  bool is_excluded(std::size_t row) const { return !excluded.empty() && excluded[row] != 0; }
  // The values of a symbol that a term reads: a channel's, or "dwell" for dwell_s. Empty: there are
  // none (or no rows).
  std::span<const double> values_of(std::string_view symbol) const {
    if (symbol == "dwell") return dwell_s;
    const auto* column = find(symbol);
    return column == nullptr ? std::span<const double>() : std::span(column->values);
  }
  PointSet set_of(std::size_t row) const { return set.empty() ? PointSet::calibration : set[row]; }
};

}  // namespace driftwise
