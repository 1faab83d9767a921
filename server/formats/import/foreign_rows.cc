#include "server/formats/import/foreign_rows.h"

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr std::size_t kMostLineBytes = 1 << 20;

bool is_space(char c) { return c == ' ' || c == '\t'; }

// CR, LF and CR LF all end a line.
std::string_view take_foreign_line(std::string_view& text) {
  const auto end = text.find_first_of("\r\n");
  const std::string_view line = text.substr(0, end);
  if (end == std::string_view::npos) {
    text = {};
  } else {
    const bool pair = text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n';
    text.remove_prefix(end + (pair ? 2 : 1));
  }
  return line;
}

}  // namespace

ForeignRows::ForeignRows(std::string_view text, const TableLayout& layout,
                         const std::string& file_name)
    : rest_(text), layout_(layout), file_name_(file_name) {
  for (int i = 0; i < layout.skip_lines && !rest_.empty(); ++i, ++line_) take_foreign_line(rest_);
}

bool ForeignRows::next() {
  while (!error_ && !rest_.empty()) {
    const std::string_view line = take_foreign_line(rest_);
    ++line_;
    if (line.size() > kMostLineBytes)
      return refuse(reasons::kLongLine, "found a line of " + std::to_string(line.size()) +
                                            " bytes, expected the rows of a table");
    if (!layout_.comment.empty() && line.starts_with(layout_.comment)) continue;
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    return split(line);
  }
  return false;
}

std::string& ForeignRows::fresh_field() {
  if (used_ == fields_.size()) fields_.emplace_back();
  fields_[used_].clear();
  return fields_[used_++];
}

bool ForeignRows::split(std::string_view row) {
  used_ = 0;
  const auto ends_here = [&](char c) {
    return layout_.blanks_separate ? is_space(c) : c == layout_.separator;
  };
  const auto skip = [&](std::size_t at) {  // blanks that do not separate
    while (at < row.size() && is_space(row[at]) && (layout_.blanks_separate || !ends_here(row[at])))
      ++at;
    return at;
  };
  std::size_t at = skip(0);
  for (;;) {
    std::string& field = fresh_field();
    if (layout_.quotes && at < row.size() && row[at] == '"') {
      for (++at;; ++at) {
        if (at >= row.size())
          return refuse(reasons::kBadQuote,
                        "field " + std::to_string(used_) +
                            ": found no closing quote on this line: are quotes part "
                            "of the text (quotes = false)?");
        if (row[at] != '"') {
          field += row[at];
        } else if (at + 1 < row.size() && row[at + 1] == '"') {
          field += row[at++];
        } else {
          break;
        }
      }
      at = skip(at + 1);
      if (at < row.size() && !ends_here(row[at]) && !layout_.blanks_separate)
        return refuse(reasons::kBadQuote, "field " + std::to_string(used_) + ": found " +
                                              shown(row.substr(at, 12)) +
                                              " after the closing quote, expected the separator");
    } else {
      const std::size_t start = at;
      while (at < row.size() && !ends_here(row[at])) ++at;
      std::size_t end = at;
      while (end > start && is_space(row[end - 1])) --end;
      field.assign(row.substr(start, end - start));
    }
    if (layout_.blanks_separate) at = skip(at);
    if (at >= row.size()) break;
    if (!layout_.blanks_separate) at = skip(at + 1);  // past the separator
  }
  fields_.resize(used_);
  return true;
}

bool ForeignRows::refuse(Reason reason, const std::string& sentence) {
  error_ = Error{ErrorCode::invalid_argument, reason, at_line(file_name_, line_) + sentence};
  return false;
}

}  // namespace driftwise::formats
