#include "clients/cli/core/table.h"

#include <algorithm>

#include "server/core/text/clean_text.h"

namespace driftwise::cli {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

namespace {

std::string painted(const Table::Cell& cell, const Paint& paint) {
  switch (cell.text.empty() ? Colour::none : cell.colour) {
    case Colour::none:
      return cell.text;
    case Colour::good:
      return paint.good(cell.text);
    case Colour::warn:
      return paint.warn(cell.text);
    case Colour::bad:
      return paint.bad(cell.text);
    case Colour::dim:
      return paint.dim(cell.text);
  }
  return cell.text;
}

}  // namespace

void Table::add(std::vector<Cell> row) {
  for (auto& cell : row) cell.text = clean_line(cell.text);
  rows_.push_back(std::move(row));
}

// A column is as wide as its longest cell of up to kWidest characters. A longer cell stands out in
// its own row: blanks in all others would make them as long.
void Table::print(std::ostream& out, const Paint& paint) const {
  constexpr std::size_t kWidest = 40;
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::size_t width = width_of(columns_[i].header);
    for (const auto& row : rows_)
      if (i < row.size() && width_of(row[i].text) <= kWidest)
        width = std::max(width, width_of(row[i].text));
    widths.push_back(width);
  }
  const auto line_of = [&](const std::vector<Cell>& cells) {
    std::string line;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const Cell cell = i < cells.size() ? cells[i] : "";
      const std::string padding(widths[i] - std::min(widths[i], width_of(cell.text)), ' ');
      const std::string text = painted(cell, paint);
      if (i > 0) line += "  ";
      line += columns_[i].align == Align::right ? padding + text : text + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line;
  };
  std::vector<Cell> headers;
  for (const auto& column : columns_) headers.push_back(column.header);
  out << paint.bold(line_of(headers)) << '\n';
  for (const auto& row : rows_) out << line_of(row) << '\n';
}

}  // namespace driftwise::cli
