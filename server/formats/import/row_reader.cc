#include "server/formats/import/row_reader.h"

#include <algorithm>
#include <cmath>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using ColumnTarget = ColumnRule::Target;
constexpr double kLargestWhole = 9007199254740992.0;  // 2^53: up to here doubles hold them all

// "1.5" where a comma is the decimal mark is the commonest slip.
std::string mark_hint(const std::string& text, const NumberStyle& style) {
  const char other = style.decimal == '.' ? ',' : '.';
  if (text.find(other) == std::string::npos) return "";
  return " (the mapping says decimal = \"" + std::string(1, style.decimal) + "\")";
}

// A column taken by its number whose name is a measurement: the first row is data.
bool is_data(const SourceTable& table, const SourceColumn& column, std::size_t field,
             const NumberStyle& style) {
  return table.has_header && column.name.empty() &&
         number_in(table.names[field], style).has_value();
}

Error no_header(const SourceTable& table, std::size_t field, const std::string& place,
                const std::string& file_name) {
  return {ErrorCode::invalid_argument, reasons::kNoHeader,
          at_line(file_name, table.header_line) + place + " of the mapping: found " +
              shown(table.names[field]) + " in the header row, expected the column's name: " +
              "header = false in [file], or comment = \"%\" (any other mark) where the header " +
              "begins with '#'; names that are numbers: header = false and skip_lines"};
}

}  // namespace

Result<RowReader> RowReader::make(const ImportMapping& mapping, const SourceTable& table,
                                  const std::string& file_name) {
  RowReader out(mapping, table, file_name);
  std::optional<Error> first;
  const auto find = [&](const SourceColumn& column, const std::string& place) {
    const auto field = table.find(column, place, file_name);
    if (field && is_data(table, column, *field, mapping.file.numbers) && !first)
      first = no_header(table, *field, place, file_name);
    if (field) return *field;
    if (!first) first = field.error();
    return std::size_t{0};
  };
  if (mapping.time)
    for (const auto& column : mapping.time->columns) out.times_.push_back(find(column, "time"));
  for (const auto& rule : mapping.columns) {
    const bool plain = rule.scale == 1 && rule.offset == 0;
    out.shifts_.push_back(plain ? rule.convert.decimal_shift() : std::nullopt);
    out.columns_.push_back(find(rule.source, "column " + std::to_string(out.columns_.size() + 1)));
  }
  for (const auto& rule : mapping.drops)
    out.drops_.push_back(find(rule.source, "drop " + std::to_string(out.drops_.size() + 1)));
  if (mapping.sets.by == SetRule::By::column) out.set_ = find(mapping.sets.source, "sets");
  if (first) return tl::unexpected(*first);
  return out;
}

std::vector<bool> RowReader::used() const {
  std::vector<bool> out(table_->names.size());
  for (const auto* fields : {&columns_, &drops_, &times_})
    for (const std::size_t field : *fields) out[field] = true;
  if (mapping_->sets.by == SetRule::By::column) out[set_] = true;
  return out;
}

Error RowReader::problem(const ForeignRows& row, std::size_t field, Reason reason,
                         const std::string& sentence) const {
  return {ErrorCode::invalid_argument, reason,
          at_line(*file_name_, row.line()) + table_->shown_name(field) + ": " + sentence};
}

bool RowReader::is_missing_text(const std::string& text) const {
  return std::ranges::find(mapping_->file.missing, text) != mapping_->file.missing.end();
}

Result<double> RowReader::number(const ForeignRows& row, std::size_t field, int shift) const {
  const std::string& text = row.fields()[field];
  if (is_missing_text(text)) return kMissing;
  const auto found = number_in(text, mapping_->file.numbers, shift);
  if (found) return *found;
  return tl::unexpected(problem(row, field, reasons::kBadNumber,
                                "found " + (text.empty() ? std::string("nothing") : shown(text)) +
                                    ", expected a finite number" +
                                    mark_hint(text, mapping_->file.numbers) +
                                    ", or a text that the mapping's file.missing lists"));
}

Result<double> RowReader::value(const ForeignRows& row, std::size_t index) const {
  const ColumnRule& rule = mapping_->columns[index];
  const std::size_t field = columns_[index];
  const auto shift = shifts_[index];
  const auto found = number(row, field, shift.value_or(0));
  if (!found) return found;
  if (is_missing(*found)) {
    const bool needed = rule.required || (rule.target != ColumnTarget::channel &&
                                          rule.target != ColumnTarget::dwell);
    if (!needed) return kMissing;
    return tl::unexpected(
        problem(row, field, reasons::kMissingValue,
                "found " + shown(row.fields()[field]) + ", expected a number in every row"));
  }
  const double out = shift ? *found : rule.convert(*found * rule.scale + rule.offset);
  if (!std::isfinite(out))
    return tl::unexpected(problem(row, field, reasons::kBadNumber,
                                  "found " + shown(row.fields()[field]) +
                                      ", which is no finite number in the channel's unit"));
  if (rule.is_spread() && out < 0)
    return tl::unexpected(problem(row, field, reasons::kBadNumber,
                                  "found " + shown(row.fields()[field]) +
                                      ", expected 0 or more: the channel " + rule.channel.name() +
                                      " is a spread"));
  if (rule.target == ColumnTarget::zero && out != 0 && out != 1)
    return tl::unexpected(problem(row, field, reasons::kBadFlag,
                                  "found " + shown(row.fields()[field]) + ", expected 0 or 1"));
  const bool whole = rule.target == ColumnTarget::line || rule.target == ColumnTarget::run ||
                     rule.target == ColumnTarget::datum;
  if (whole && (std::trunc(out) != out || std::abs(out) > kLargestWhole))
    return tl::unexpected(
        problem(row, field, reasons::kBadInteger,
                "found " + shown(row.fields()[field]) + ", expected a whole number"));
  return out;
}

Result<void> RowReader::read(const ForeignRows& row, std::vector<double>& values) const {
  values.resize(columns_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    DRIFTWISE_TRY(const auto found, value(row, i));
    values[i] = found;
  }
  return {};
}

Result<std::optional<std::size_t>> RowReader::dropped_by(const ForeignRows& row) const {
  for (std::size_t i = 0; i < drops_.size(); ++i) {
    const DropRule& rule = mapping_->drops[i];
    const std::string& text = row.fields()[drops_[i]];
    if (rule.missing && is_missing_text(text)) return i;
    if (rule.equals && text == *rule.equals) return i;
    if (!rule.below && !rule.above) continue;
    DRIFTWISE_TRY(const auto found, number(row, drops_[i]));
    if ((rule.below && found < *rule.below) || (rule.above && found > *rule.above)) return i;
  }
  return std::nullopt;
}

Result<RowReader::Stamp> RowReader::time(const ForeignRows& row) const {
  std::string text;
  for (const std::size_t field : times_) text += (text.empty() ? "" : " ") + row.fields()[field];
  const auto found = mapping_->time->format.read(text, mapping_->file.numbers.decimal);
  if (found) return Stamp{*found, mapping_->time->format.is_local(text)};
  return tl::unexpected(problem(row, times_.front(), reasons::kBadTime, found.error().message));
}

Result<bool> RowReader::is_validation(const ForeignRows& row) const {
  const std::string& text = row.fields()[set_];
  if (is_missing_text(text))
    return tl::unexpected(
        problem(row, set_, reasons::kBadSet, "found " + shown(text) + ", expected the row's set"));
  return std::ranges::find(mapping_->sets.validation, text) != mapping_->sets.validation.end();
}

}  // namespace driftwise::formats
