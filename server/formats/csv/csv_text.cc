#include "server/formats/csv/csv_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <unordered_map>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/text/trimmed.h"
#include "server/core/try.h"
#include "server/formats/csv/plain_decimal.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr std::string_view kBlank = " \t";

std::string_view trimmed(std::string_view text) { return driftwise::trimmed(text, kBlank); }

bool is_blank(char c) { return c == ' ' || c == '\t'; }

// Takes one line off the front, without its end (LF or CRLF).
std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

tl::unexpected<Error> bad(std::string reason, const std::string& file_name, std::size_t line,
                          const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, std::move(reason), at_line(file_name, line) + sentence);
}

// Returns inside a line become blanks when it is written: at the ends of a text they are blanks
// already.
std::string_view trimmed_remark(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// A line without a key is a remark: it stays whole, so that it is written as it was read.
std::pair<std::string, std::string> metadata_from(std::string_view line) {
  const auto body = trimmed_remark(line.substr(1));
  const auto colon = body.find(':');
  const auto key = trimmed_remark(body.substr(0, colon));
  if (colon == std::string_view::npos || key.empty()) return {"", clean_line(body)};
  return {clean_line(key), clean_line(trimmed_remark(body.substr(colon + 1)))};
}

// Text that no number was meant with: "ok", and not "1.5mm" or "nan".
bool is_words(std::string_view text) {
  const auto is_letter = [](char c) { return (c | 0x20) >= 'a' && (c | 0x20) <= 'z'; };
  return std::ranges::any_of(text, is_letter) &&
         text.find_first_of("0123456789") == std::string_view::npos && !text.ends_with("nan") &&
         !text.ends_with("inf");
}

bool is_number(std::string_view text) {
  double value = 0;
  const auto [after, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && after == text.data() + text.size() && code != std::errc::invalid_argument;
}

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

// The last one counts without its end, too.
std::size_t lines_in(std::string_view text) {
  std::size_t lines = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    ++lines;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

// Names of the header row, left to right.
Result<void> read_names(std::string_view line, const std::string& file_name,
                        const CsvLimits& limits, CsvHeader& header) {
  std::unordered_map<std::string_view, std::size_t> places;  // views into the text
  for (std::string_view rest = line;
       !rest.empty() || header.names.empty() || line.ends_with(',');) {
    const auto comma = rest.find(',');
    const std::string_view name = trimmed(rest.substr(0, comma));
    const std::size_t number = header.names.size() + 1;
    const auto refuse = [&](Reason reason, const std::string& sentence) {
      return bad(reason, file_name, header.line, sentence);
    };
    if (number > limits.columns)
      return refuse(reasons::kTooManyColumns,
                    "found more than " + std::to_string(limits.columns) +
                        " columns, expected one per channel: is it a table "
                        "with one row per point?");
    if (name.size() > limits.name_bytes)
      return refuse(reasons::kNameTooLong, "column " + std::to_string(number) + ": found " +
                                               shown(name) + " of " + std::to_string(name.size()) +
                                               " bytes, expected at most " +
                                               std::to_string(limits.name_bytes));
    if (name.find('"') != std::string_view::npos)
      return refuse(reasons::kQuotedField, "column " + std::to_string(number) + ": found " +
                                               shown(name) + ", expected a name without quotes");
    if (name.empty())
      return refuse(reasons::kNoHeader,
                    "column " + std::to_string(number) + " has no name" +
                        (comma == std::string_view::npos && number > 1
                             ? ": leave out the comma at the end of the line, here and in the rows"
                             : ": name it, or leave the column out"));
    if (is_number(name))
      return refuse(reasons::kNoHeader,
                    "found the number " + shown(name) + " where column " + std::to_string(number) +
                        " has its name: the file needs a header row such as time_s,q1_mm,x_mm "
                        "above its numbers");
    if (name.find(';') != std::string_view::npos)
      return refuse(
          reasons::kNoHeader,
          "found " + shown(name) + ": fields are separated by commas and decimals by points");
    const auto [twin, is_new] = places.emplace(name, number);
    if (!is_new)
      return refuse(reasons::kDuplicateColumn,
                    "columns " + std::to_string(twin->second) + " and " + std::to_string(number) +
                        " are both named " + shown(name) + ": rename one of them, or leave it out");
    header.names.emplace_back(name);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  return {};
}

}  // namespace

Result<CsvHeader> read_csv_header(std::string_view text, const std::string& file_name,
                                  const CsvLimits& limits) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    return bad(reasons::kNotText, file_name, 1,
               "found UTF-16 text, expected UTF-8 or plain ASCII: save the file as UTF-8");
  const std::string_view first = text.substr(0, limits.header_bytes);
  if (first.find('\n') == std::string_view::npos)
    if (const auto cr = first.find('\r'); cr != std::string_view::npos && cr + 1 < text.size())
      return bad(reasons::kNotText, file_name, 1,
                 "found lines that end in a carriage return alone, expected LF or CR LF: save the "
                 "file as CSV for Windows or Unix");
  CsvHeader header;
  std::string_view line;
  do {
    if (text.empty())
      return header.line == 0
                 ? bad(reasons::kEmptyFile, file_name, 1,
                       "the file is empty, expected a header row such as time_s,q1_mm,x_mm")
                 : bad(reasons::kNoHeader, file_name, header.line,
                       "found no header row before the end of the file, expected names such as "
                       "time_s,q1_mm,x_mm");
    ++header.line;
    const std::string_view start = text.substr(0, limits.header_bytes);
    if (const auto zero = start.substr(0, start.find('\n')).find('\0');
        zero != std::string_view::npos)
      return bad(reasons::kNotText, file_name, header.line, "found a zero byte, expected text");
    if (start.size() < text.size() && start.find('\n') == std::string_view::npos) {
      if (const auto names = read_names(start, file_name, limits, header);
          !names && names.error().reason == reasons::kTooManyColumns)
        return tl::unexpected(names.error());  // says more than the length of the line
      return bad(reasons::kHeaderTooLong, file_name, header.line,
                 "found no end of the line within " + std::to_string(limits.header_bytes) +
                     " bytes, expected a header row such as time_s,q1_mm,x_mm");
    }
    line = take_line(text);
    if (!line.starts_with('#')) continue;
    if (header.metadata.size() >= limits.metadata_lines)
      return bad(reasons::kTooMuchMetadata, file_name, header.line,
                 "found more than " + std::to_string(limits.metadata_lines) +
                     " lines of metadata before the header row");
    header.metadata.push_back(metadata_from(line));
  } while (line.empty() || line.starts_with('#'));
  DRIFTWISE_RETURN_IF_ERROR(read_names(line, file_name, limits, header));
  header.rows = text;
  return header;
}

std::vector<CsvChunk> chunks_of(const CsvHeader& header, const calibration::Executor& executor) {
  std::vector<CsvChunk> chunks;
  for (std::string_view rest = header.rows; !rest.empty() || chunks.empty();) {
    const auto end = rest.find('\n', std::min(kChunkBytes, rest.size()));
    const std::size_t size = end == std::string_view::npos ? rest.size() : end + 1;
    chunks.push_back({rest.substr(0, size), 0, 0, 0});
    rest.remove_prefix(size);
  }
  std::vector<std::size_t> lines(chunks.size());
  calibration::run_on(executor, chunks.size(),
                      [&](std::size_t i) { lines[i] = lines_in(chunks[i].rows); });
  std::size_t line = header.line, row = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    auto& chunk = chunks[i];
    chunk.line = line;
    chunk.first_row = row;
    // A row has a comma or an end after each field: empty lines need no room.
    chunk.most_rows = std::min(lines[i], chunk.rows.size() / header.names.size() + 1);
    line += lines[i];
    row += chunk.most_rows;
  }
  return chunks;
}

CsvRows::CsvRows(const CsvHeader& header, const std::string& file_name, const CsvChunk& chunk)
    : at_(chunk.rows.data()),
      end_(chunk.rows.data() + chunk.rows.size()),
      line_(chunk.line),
      names_(header.names),
      file_name_(file_name) {}

bool CsvRows::next_row() {
  if (failed_) return false;
  for (;;) {
    if (in_row_) {  // step over the end of the line just read
      if (at_ != end_ && *at_ == '\r') ++at_;
      if (at_ != end_) ++at_;
      in_row_ = false;
    }
    if (at_ == end_) return false;
    ++line_;
    in_row_ = true;
    row_ = at_;
    column_ = 0;
    if (*at_ != '\n' && !(*at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n')) return true;
  }
}

bool CsvRows::number(double& value) {
  field_ = at_;
  while (at_ != end_ && is_blank(*at_)) ++at_;
  if (at_ == end_ || *at_ == ',' || *at_ == '\n' || *at_ == '\r') {
    value = kMissing;
    return finish_field(at_, "a number or nothing", reasons::kBadNumber);
  }
  constexpr const char* kExpected = "a finite number such as -1.5e-3, or nothing";
  if (const char* after = read_plain_decimal(at_, end_, value))
    return finish_field(after, kExpected, reasons::kBadNumber);
  // from_chars knows no plus, and does not tell 1e-400, which is zero, from 1e400.
  const char* first = at_;
  if (*first == '+' && first + 1 != end_ && first[1] != '-') ++first;
  const auto [after, code] = std::from_chars(first, end_, value);
  if (code == std::errc::result_out_of_range)
    value = std::strtod(std::string(first, after).c_str(), nullptr);
  else if (code != std::errc{})
    return refuse(reasons::kBadNumber, kExpected);
  if (!std::isfinite(value)) return refuse(reasons::kBadNumber, kExpected);
  return finish_field(after, kExpected, reasons::kBadNumber);
}

bool CsvRows::integer(std::int64_t& value) {
  field_ = at_;
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const auto [after, code] = std::from_chars(at_, end_, value);
  if (code != std::errc{}) return refuse(reasons::kBadInteger, "a whole number");
  return finish_field(after, "a whole number", reasons::kBadInteger);
}

bool CsvRows::flag(bool& value) {
  std::int64_t number = 0;
  field_ = at_;
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const auto [after, code] = std::from_chars(at_, end_, number);
  if (code != std::errc{} || (number != 0 && number != 1))
    return refuse(reasons::kBadFlag, "0 or 1");
  value = number == 1;
  return finish_field(after, "0 or 1", reasons::kBadFlag);
}

bool CsvRows::set_is_validation(bool& value) {
  field_ = at_;
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const std::string_view rest(at_, static_cast<std::size_t>(end_ - at_));
  std::size_t length = std::min(rest.find_first_of(",\r\n"), rest.size());
  while (length > 0 && is_blank(rest[length - 1])) --length;
  const std::string_view word = rest.substr(0, length);
  if (!is_set_name(word)) return refuse(reasons::kBadSet, kSetNameExpected);
  value = word != "calibration";
  return finish_field(at_ + length, kSetNameExpected, reasons::kBadSet);
}

bool CsvRows::text(std::string& value) {
  field_ = at_;
  const std::string_view found = field();
  value = found;
  const std::string_view rest(at_, static_cast<std::size_t>(end_ - at_));
  const std::size_t length = std::min(rest.find_first_of(",\r\n"), rest.size());
  return finish_field(at_ + length, "text", reasons::kBadText);
}

bool CsvRows::finish_field(const char* after, const char* expected, Reason reason) {
  at_ = after;
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const bool last = column_ + 1 == names_.size();
  if (at_ != end_ && *at_ == ',') {
    if (last) return refuse(reasons::kRaggedRow, nullptr);
    ++at_;
  } else if (at_ == end_ || *at_ == '\n' || (*at_ == '\r' && (at_ + 1 == end_ || at_[1] == '\n'))) {
    if (!last) return refuse(reasons::kRaggedRow, nullptr);
  } else {
    return refuse(reason, expected);
  }
  ++column_;
  return true;
}

// The slow path: everything about the row is looked up again from its start.
bool CsvRows::refuse(Reason reason, const char* expected) {
  failed_ = true;
  if (expected == nullptr) {
    const auto fields = static_cast<std::size_t>(std::ranges::count(row(), ',')) + 1;
    error_ = problem(reason, names_.size(),
                     "found " + std::to_string(fields) + (fields == 1 ? " field" : " fields") +
                         ", expected " + std::to_string(names_.size()) + " as in the header row" +
                         surplus(fields));
  } else if (const auto text = field(); text.find('"') != std::string_view::npos) {
    error_ =
        problem(reasons::kQuotedField, column_, "found " + shown(text) + ", expected no quotes");
  } else {
    error_ = problem(reason, column_,
                     "found " + (text.empty() ? std::string("nothing") : shown(text)) +
                         ", expected " + expected);
    if (error_.reason == reasons::kBadNumber && is_words(text))
      error_.message += ": leave a column of text out";
  }
  return false;
}

// Advice on a row with more fields than columns; empty where there are fewer.
std::string CsvRows::surplus(std::size_t fields) const {
  if (fields <= names_.size()) return "";
  if (row().ends_with(',')) return ": leave out the comma at the end of the line";
  if (fields == 2 * names_.size())
    return ": twice as many, as of decimal commas: write decimals with points, or part the fields "
           "by semicolons and read the file with driftwise data import FILE --mapping MAP.toml "
           "(decimal = \",\", docs/import.md)";
  return "";
}

std::string_view CsvRows::row() const {
  std::string_view rest(row_, static_cast<std::size_t>(end_ - row_));
  return take_line(rest);
}

std::string_view CsvRows::field() const {
  const std::string_view rest(field_, static_cast<std::size_t>(end_ - field_));
  return trimmed(rest.substr(0, rest.find_first_of(",\r\n")));
}

Error CsvRows::problem(std::string reason, std::size_t column, const std::string& sentence) const {
  const std::string place = column < names_.size() ? "column " + names_[column] + ": " : "";
  return {ErrorCode::invalid_argument, std::move(reason),
          at_line(file_name_, line_) + place + sentence};
}

}  // namespace driftwise::formats
