#pragma once
// A measurement file of another program + its mapping -> a dataset, and an account of what was
// understood and what was left out.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/formats/import/import_mapping.h"

namespace driftwise::formats {

struct ImportReport {
  struct Column {
    std::string source, unit;  // the header's name (or "column 3") and the unit it was read in
    std::string channel;       // "goal_x_mm", "line"
    std::string first;         // the field of the first row, as it stands
    double min = kMissing, max = kMissing;  // in the channel's unit
    std::size_t missing = 0;
  };
  struct Dropped {
    std::string why;
    std::size_t rows = 0;
    std::vector<std::size_t> lines;  // the first of them, ten at most
  };
  std::size_t rows_read = 0, rows_kept = 0;
  std::vector<Column> columns;
  std::vector<std::string> unused;  // names of the file's columns that no rule reads
  std::vector<Dropped> dropped;     // one per drop rule, in the mapping's order
  std::size_t late_rows = 0;        // rows that stood after a later one, and were put in order
  std::size_t spread_rows = 0;      // rows whose stamp was shared with the row before
  std::size_t groups = 0, smallest_group = 0, largest_group = 0;
  double median_group = 0;
  std::size_t calibration = 0, validation = 0;
  std::string time_zero;  // ISO 8601; empty when untimed or counted from any start
};

struct ImportedDataset {
  Dataset dataset;
  ImportReport report;
};

constexpr std::size_t kMostImportBytes = std::size_t{1} << 30;  // when inflated

// bytes: the file as it is, gzip or not. file_name: stands in front of messages, and in the
// dataset's metadata with the hash of the bytes.
// Errors, invalid_argument, each naming file:line, the column, found and expected: those of gunzip,
// to_utf8 and ForeignRows; NO_HEADER, NO_ROWS, ALL_DROPPED, UNKNOWN_COLUMN, AMBIGUOUS_COLUMN,
// RAGGED_ROW, BAD_NUMBER, BAD_INTEGER, BAD_FLAG, MISSING_VALUE, BAD_TIME, TIME_NOT_INCREASING,
// BAD_SET, BAD_METADATA (a slip in a line of [metadata] that a computation reads).
Result<ImportedDataset> import_dataset(std::string_view bytes, const std::string& file_name,
                                       const ImportMapping& mapping);

}  // namespace driftwise::formats
