#include "server/formats/text/row_ranges.h"

#include <algorithm>
#include <charconv>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

bool whole_number(std::string_view text, std::int64_t& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, number);
  return code == std::errc{} && stop == end && !text.empty() && number >= 0;
}

// rest: the first row that is in none of them.
std::string first_ranges(const std::vector<std::int64_t>& rows, std::size_t most,
                         std::size_t& rest) {
  std::string text;
  for (std::size_t ranges = 0; rest < rows.size() && ranges < most; ++ranges) {
    std::size_t last = rest;
    while (last + 1 < rows.size() && rows[last + 1] == rows[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(rows[rest]);
    if (last > rest) text += "-" + std::to_string(rows[last]);
    rest = last + 1;
  }
  return text;
}

}  // namespace

Result<std::vector<std::int64_t>> parse_row_ranges(std::string_view text) {
  std::vector<std::int64_t> rows;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view piece = without_blanks(text.substr(0, comma));
    const std::size_t dash = piece.find('-');
    std::int64_t first = 0, last = 0;
    const bool good = dash == std::string_view::npos
                          ? whole_number(piece, first) && whole_number(piece, last)
                          : whole_number(without_blanks(piece.substr(0, dash)), first) &&
                                whole_number(without_blanks(piece.substr(dash + 1)), last) &&
                                first <= last;
    if (!good)
      return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                  "rows: found " + shown(piece) + ", expected row numbers such as 12,40-45");
    if (last - first >= static_cast<std::int64_t>(kMostRows - rows.size()))
      return fail(ErrorCode::invalid_argument, reasons::kBadRows,
                  "rows: found " + shown(piece) + ", expected at most " +
                      std::to_string(kMostRows) + " rows in all");
    for (std::int64_t row = first; row <= last; ++row) rows.push_back(row);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

std::string row_ranges_text(const std::vector<std::int64_t>& rows) {
  std::size_t rest = 0;
  return first_ranges(rows, rows.size(), rest);
}

std::string row_ranges_told(const std::vector<std::int64_t>& rows) {
  constexpr std::size_t kTold = 10;
  std::size_t rest = 0;
  auto text = first_ranges(rows, kTold, rest);
  if (rest < rows.size())
    text += " and " + std::to_string(rows.size() - rest) + " more (" + std::to_string(rows.size()) +
            " rows)";
  return text;
}

std::string exclusions_hash(const Dataset& dataset) {
  std::vector<std::int64_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.is_excluded(row) && !is_passage(dataset, row))
      rows.push_back(static_cast<std::int64_t>(row));
  return rows.empty() ? std::string() : content_hash(row_ranges_text(rows));
}

}  // namespace driftwise::formats
