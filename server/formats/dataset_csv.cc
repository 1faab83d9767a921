#include "server/formats/dataset_csv.h"

#include <array>

#include "server/formats/csv_text.h"
#include "server/formats/text.h"

namespace driftwise::formats {
namespace {

constexpr std::string_view kVersionKey = "driftwise-dataset";

enum class DatasetColumn : std::uint8_t {
  time,
  set,
  line,
  zero,
  dwell,
  run,
  datum,
  excluded,
  channel
};

struct Named {
  std::string_view name;
  DatasetColumn kind;
};
constexpr std::array<Named, 8> kOwnColumns = {{{"time_s", DatasetColumn::time},
                                               {"set", DatasetColumn::set},
                                               {"line", DatasetColumn::line},
                                               {"zero", DatasetColumn::zero},
                                               {"dwell_s", DatasetColumn::dwell},
                                               {"run", DatasetColumn::run},
                                               {"datum", DatasetColumn::datum},
                                               {"excluded", DatasetColumn::excluded}}};

struct Column {
  DatasetColumn kind = DatasetColumn::channel;
  std::vector<double>* values = nullptr;  // where a number goes
};

Result<void> check_version(const CsvHeader& header, const std::string& file_name) {
  for (const auto& [key, value] : header.metadata)
    if (key == kVersionKey && value != "1")
      return fail(ErrorCode::invalid_argument, "UNSUPPORTED_VERSION",
                  at_line(file_name, 1) + "found driftwise-dataset " + shown(value) +
                      ", expected version 1");
  return {};
}

// Fills data.columns and says for each column of the file what it is.
Result<std::vector<Column>> sort_columns(const CsvHeader& header, const std::string& file_name,
                                         Dataset& data) {
  std::vector<Column> columns(header.names.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& name = header.names[i];
    for (const auto& own : kOwnColumns)
      if (name == own.name) columns[i].kind = own.kind;
    if (columns[i].kind != DatasetColumn::channel) continue;
    auto channel = parse_channel(name);
    if (!channel) {
      std::string message = at_line(file_name, header.line) + "column " + std::to_string(i + 1) +
                            ": " + channel.error().message;
      return fail(ErrorCode::invalid_argument, channel.error().reason, std::move(message));
    }
    data.columns.push_back({std::move(*channel), {}});
  }
  std::size_t next = 0;
  for (auto& column : columns) {
    if (column.kind == DatasetColumn::time) column.values = &data.time_s;
    if (column.kind == DatasetColumn::dwell) column.values = &data.dwell_s;
    if (column.kind == DatasetColumn::channel) column.values = &data.columns[next++].values;
    if (column.values) column.values->reserve(header.row_bound);
  }
  return columns;
}

bool read_row(CsvRows& rows, const std::vector<Column>& columns, Dataset& data) {
  for (const auto& column : columns) {
    double number = 0;
    std::int64_t integer = 0;
    bool truth = false;
    switch (column.kind) {
      case DatasetColumn::time:
      case DatasetColumn::dwell:
      case DatasetColumn::channel:
        if (!rows.number(number)) return false;
        column.values->push_back(number);
        break;
      case DatasetColumn::set:
        if (!rows.set_is_validation(truth)) return false;
        data.set.push_back(truth ? PointSet::validation : PointSet::calibration);
        break;
      case DatasetColumn::zero:
        if (!rows.flag(truth)) return false;
        data.zero.push_back(truth ? 1 : 0);
        break;
      case DatasetColumn::line:
        if (!rows.integer(integer)) return false;
        data.line.push_back(integer);
        break;
      case DatasetColumn::run:
        if (!rows.integer(integer)) return false;
        data.run.push_back(integer);
        break;
      case DatasetColumn::datum:
        if (!rows.integer(integer)) return false;
        data.datum.push_back(integer);
        break;
      case DatasetColumn::excluded:
        if (!rows.flag(truth)) return false;
        data.excluded.push_back(truth ? 1 : 0);
        break;
    }
  }
  return true;
}

std::size_t time_column(const std::vector<Column>& columns) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].kind == DatasetColumn::time) return i;
  return columns.size();
}

}  // namespace

Result<Dataset> read_dataset_csv(std::string_view text, const std::string& file_name) {
  const auto header = read_csv_header(text, file_name);
  if (!header) return tl::unexpected(header.error());
  if (auto version = check_version(*header, file_name); !version)
    return tl::unexpected(version.error());
  Dataset data;
  data.metadata = header->metadata;
  const auto columns = sort_columns(*header, file_name, data);
  if (!columns) return tl::unexpected(columns.error());

  CsvRows rows(*header, file_name);
  while (rows.next_row()) {
    if (!read_row(rows, *columns, data)) break;
    ++data.rows;
    if (data.time_s.empty()) continue;
    const double now = data.time_s.back();
    if (is_missing(now))
      return tl::unexpected(
          rows.problem("BAD_NUMBER", time_column(*columns), "found nothing, expected seconds"));
    if (data.rows > 1 && !(now > data.time_s[data.rows - 2]))
      return tl::unexpected(rows.problem("TIME_NOT_INCREASING", time_column(*columns),
                                         "found " + number_text(now) + " after " +
                                             number_text(data.time_s[data.rows - 2]) +
                                             ", expected a later time in every row"));
  }
  if (rows.failed()) return tl::unexpected(rows.error());
  if (data.rows == 0)
    return fail(ErrorCode::invalid_argument, "NO_ROWS",
                at_line(file_name, header->line) +
                    "found a header row and nothing after it, expected one row per point");
  return data;
}

std::string write_dataset_csv(const Dataset& data) {
  std::string out;
  out.reserve(256 + data.rows * (64 + 20 * data.columns.size()));
  bool has_version = false;
  for (const auto& [key, value] : data.metadata) has_version = has_version || key == kVersionKey;
  if (!has_version) out += "# driftwise-dataset: 1\n";
  for (const auto& [key, value] : data.metadata) {
    std::string line = key.empty() ? "# " + value : "# " + key + ": " + value;
    for (char& c : line)
      if (c == '\n' || c == '\r') c = ' ';
    out += line + "\n";
  }

  const std::size_t header_start = out.size();
  const auto name = [&](std::string_view text) {
    out.append(out.size() > header_start ? "," : "").append(text);
  };
  if (!data.time_s.empty()) name("time_s");
  if (!data.run.empty()) name("run");
  if (!data.datum.empty()) name("datum");
  if (!data.set.empty()) name("set");
  if (!data.line.empty()) name("line");
  if (!data.zero.empty()) name("zero");
  if (!data.dwell_s.empty()) name("dwell_s");
  if (!data.excluded.empty()) name("excluded");
  for (const auto& column : data.columns) name(column.channel.name());
  out += '\n';

  for (std::size_t row = 0; row < data.rows; ++row) {
    const std::size_t row_start = out.size();
    bool first = true;
    const auto next = [&] {
      if (!first) out += ',';
      first = false;
    };
    if (!data.time_s.empty()) next(), append_number(out, data.time_s[row]);
    if (!data.run.empty()) next(), append_number(out, data.run[row]);
    if (!data.datum.empty()) next(), append_number(out, data.datum[row]);
    if (!data.set.empty())
      next(), out += data.set[row] == PointSet::validation ? "validation" : "calibration";
    if (!data.line.empty()) next(), append_number(out, data.line[row]);
    if (!data.zero.empty()) next(), out += data.zero[row] ? '1' : '0';
    if (!data.dwell_s.empty()) next(), append_number(out, data.dwell_s[row]);
    if (!data.excluded.empty()) next(), out += data.excluded[row] ? '1' : '0';
    for (const auto& column : data.columns) next(), append_number(out, column.values[row]);
    if (out.size() == row_start)
      out += ' ';  // a lone empty field: an empty line would be passed over
    out += '\n';
  }
  return out;
}

}  // namespace driftwise::formats
