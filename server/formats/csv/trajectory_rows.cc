#include "server/formats/csv/trajectory_rows.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/text/row_ranges.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

std::size_t rows_of_plan(const Dataset& dataset) {
  std::size_t count = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!is_passage(dataset, row)) ++count;
  return count;
}

std::vector<std::int64_t> counted_rows(std::size_t count) {
  std::vector<std::int64_t> rows(count);
  std::iota(rows.begin(), rows.end(), std::int64_t{1});
  return rows;
}

// Piece by piece: parse_row_ranges sorts, and the order is what the line is there for.
Result<std::vector<std::int64_t>> unpacked(std::string_view line) {
  std::vector<std::int64_t> rows;
  while (true) {
    const std::size_t comma = line.find(',');
    DRIFTWISE_TRY(const auto piece, parse_row_ranges(line.substr(0, comma)));
    if (rows.size() + piece.size() > kMostRows)
      return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                  "rows: found more than " + std::to_string(kMostRows) + " rows");
    rows.insert(rows.end(), piece.begin(), piece.end());
    if (comma == std::string_view::npos) return rows;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<std::vector<std::int64_t>> trajectory_rows(const Dataset& dataset,
                                                  const std::string& file_name) {
  const std::size_t count = rows_of_plan(dataset);
  const auto line = std::ranges::find(dataset.metadata, std::string(kTrajectoryRowsKey),
                                      &std::pair<std::string, std::string>::first);
  if (line == dataset.metadata.end()) return counted_rows(count);
  constexpr const char* kWayOut =
      ": rows were taken out of the file or put in after its export; export the run again, or "
      "give each row its number in the trajectory, from 1, in a column row_1";
  const auto rows = unpacked(line->second);
  if (!rows)
    return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                file_name + ": # trajectory_rows: " + rows.error().message + kWayOut);
  if (rows->size() != count)
    return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                file_name + ": the line # trajectory_rows names " + std::to_string(rows->size()) +
                    " rows, found " + std::to_string(count) + " rows of the trajectory" + kWayOut);
  return rows;
}

void set_trajectory_rows(Dataset& dataset, const std::vector<std::int64_t>& rows) {
  std::erase_if(dataset.metadata,
                [](const auto& line) { return line.first == kTrajectoryRowsKey; });
  if (rows.size() > kMostRows || rows == counted_rows(rows.size())) return;
  dataset.metadata.emplace_back(kTrajectoryRowsKey, row_ranges_text(rows));
}

}  // namespace driftwise::formats
