#include "server/formats/import/import_dataset.h"

#include <algorithm>
#include <utility>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/metadata_check.h"
#include "server/formats/import/foreign_rows.h"
#include "server/formats/import/grouping.h"
#include "server/formats/import/import_poses.h"
#include "server/formats/import/row_order.h"
#include "server/formats/import/row_reader.h"
#include "server/formats/import/source_table.h"
#include "server/formats/text/gzip.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using ColumnTarget = ColumnRule::Target;

tl::unexpected<Error> bad_table(Reason reason, const std::string& file_name, std::size_t line,
                                const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reason, at_line(file_name, line) + sentence);
}

// The names of the header row, or numbers when there is none; the walk then stands on the first
// row. False: the file has no such row.
bool read_names(ForeignRows& rows, bool header, SourceTable& table) {
  if (!rows.next()) return false;
  table.header_line = rows.line();
  table.has_header = header;
  for (std::size_t i = 0; i < rows.fields().size(); ++i)
    table.names.push_back(header ? rows.fields()[i] : "column " + std::to_string(i + 1));
  return true;
}

// What is gathered while the rows are read.
struct Gathering {
  const ImportMapping& mapping;
  const std::string& file_name;
  ImportedDataset out;
  std::vector<std::vector<double>> values;  // one per column rule
  RowTimes times;
  std::vector<bool> validation;
};

Result<void> take_row(Gathering& g, const RowReader& reader, const ForeignRows& row,
                      std::vector<double>& values) {
  ImportReport& report = g.out.report;
  ++report.rows_read;
  DRIFTWISE_TRY(const auto dropped, reader.dropped_by(row));
  if (dropped) {
    auto& entry = report.dropped[*dropped];
    ++entry.rows;
    if (entry.lines.size() < 10) entry.lines.push_back(row.line());
    return {};
  }
  if (auto read = reader.read(row, values); !read) return read;
  if (g.mapping.time) {
    DRIFTWISE_TRY(const auto stamp, reader.time(row));
    g.times.add(stamp.time, row.line(), stamp.local);
  }
  if (g.mapping.sets.by == SetRule::By::column) {
    DRIFTWISE_TRY(const auto validation, reader.is_validation(row));
    g.validation.push_back(validation);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    g.values[i].push_back(values[i]);
    auto& column = report.columns[i];
    if (report.rows_kept == 0) column.first = row.fields()[reader.field_of(i)];
    if (is_missing(values[i])) {
      ++column.missing;
      continue;
    }
    column.min = is_missing(column.min) ? values[i] : std::min(column.min, values[i]);
    column.max = is_missing(column.max) ? values[i] : std::max(column.max, values[i]);
  }
  ++report.rows_kept;
  return {};
}

Result<void> take_rows(Gathering& g, ForeignRows& rows, const SourceTable& table,
                       const RowReader& reader) {
  std::vector<double> values;
  bool standing = !table.has_header;  // on the first row, which is data
  while (standing || rows.next()) {
    standing = false;
    if (rows.fields().size() != table.names.size())
      return bad_table(reasons::kRaggedRow, g.file_name, rows.line(),
                       "found " + std::to_string(rows.fields().size()) + " fields, expected " +
                           std::to_string(table.names.size()) + " as in line " +
                           std::to_string(table.header_line));
    if (auto taken = take_row(g, reader, rows, values); !taken) return taken;
  }
  if (rows.error()) return tl::unexpected(*rows.error());
  if (g.out.report.rows_read == 0)
    return bad_table(reasons::kNoRows, g.file_name, rows.line(),
                     "found a header row and nothing after it, expected one row per point");
  if (g.out.report.rows_kept == 0)
    return bad_table(reasons::kAllDropped, g.file_name, rows.line(),
                     "the mapping's drop rules left none of " +
                         std::to_string(g.out.report.rows_read) + " rows");
  return {};
}

std::vector<std::int64_t> whole_numbers(const std::vector<double>& values) {
  std::vector<std::int64_t> out;
  out.reserve(values.size());
  for (const double value : values) out.push_back(static_cast<std::int64_t>(value));
  return out;
}

void place_columns(Gathering& g) {
  Dataset& data = g.out.dataset;
  data.rows = g.out.report.rows_kept;
  for (std::size_t i = 0; i < g.values.size(); ++i) {
    const ColumnRule& rule = g.mapping.columns[i];
    std::vector<double>& values = g.values[i];
    switch (rule.target) {
      case ColumnTarget::channel:
        data.columns.push_back({rule.channel, std::move(values)});
        break;
      case ColumnTarget::dwell:
        data.dwell_s = std::move(values);
        break;
      case ColumnTarget::line:
        data.line = whole_numbers(values);
        break;
      case ColumnTarget::run:
        data.run = whole_numbers(values);
        break;
      case ColumnTarget::datum:
        data.datum = whole_numbers(values);
        break;
      case ColumnTarget::zero:
        for (const double value : values) data.zero.push_back(value == 1 ? 1 : 0);
        break;
    }
  }
  for (const auto& constant : g.mapping.constants)
    data.columns.push_back({constant.channel, std::vector<double>(data.rows, constant.value)});
}

// Numbers of the groups, or of the rows where nothing groups them.
std::vector<std::int64_t> place_groups(Gathering& g) {
  Dataset& data = g.out.dataset;
  std::vector<std::int64_t> groups;
  if (!g.mapping.group) {
    for (std::size_t row = 0; row < data.rows; ++row)
      groups.push_back(static_cast<std::int64_t>(row) + 1);
    return groups;
  }
  std::vector<const DatasetColumn*> columns;
  for (const auto& name : g.mapping.group->channels)
    for (const auto& column : data.columns)
      if (column.channel.name() == name) columns.push_back(&column);
  groups = group_rows(columns, data.rows, g.mapping.group->within);
  std::vector<std::size_t> sizes(static_cast<std::size_t>(*std::ranges::max_element(groups)), 0);
  for (const auto group : groups) ++sizes[static_cast<std::size_t>(group) - 1];
  std::ranges::sort(sizes);
  ImportReport& report = g.out.report;
  report.groups = sizes.size();
  report.smallest_group = sizes.front();
  report.largest_group = sizes.back();
  const std::size_t half = sizes.size() / 2;
  report.median_group = sizes.size() % 2 == 1
                            ? static_cast<double>(sizes[half])
                            : 0.5 * static_cast<double>(sizes[half - 1] + sizes[half]);
  if (g.mapping.group->channel)
    data.columns.push_back(
        {*g.mapping.group->channel, std::vector<double>(groups.begin(), groups.end())});
  else
    data.line = groups;
  return groups;
}

void place_sets(Gathering& g, const std::vector<std::int64_t>& groups) {
  const SetRule& rule = g.mapping.sets;
  Dataset& data = g.out.dataset;
  ImportReport& report = g.out.report;
  for (std::size_t row = 0; row < data.rows; ++row) {
    bool validation = false;
    if (rule.by == SetRule::By::every) validation = is_nth_group(groups[row], rule.every);
    if (rule.by == SetRule::By::share)
      validation = is_hashed_group(groups[row], rule.share, rule.seed);
    if (rule.by == SetRule::By::column) validation = g.validation[row];
    ++(validation ? report.validation : report.calibration);
    if (rule.by != SetRule::By::nothing)
      data.set.push_back(validation ? PointSet::validation : PointSet::calibration);
  }
}

// A dataset is handed on: where its file lay is nobody's business.
std::string file_part(const std::string& path) { return path.substr(path.rfind('/') + 1); }

void place_metadata(Gathering& g, std::string_view bytes) {
  auto& metadata = g.out.dataset.metadata;
  metadata = {{"driftwise-dataset", "1"}};
  for (const auto& entry : g.mapping.metadata) metadata.push_back(entry);
  metadata.emplace_back("source", file_part(g.file_name));
  metadata.emplace_back("source_hash", content_hash(bytes));
  metadata.emplace_back("mapping", file_part(g.mapping.name));
  metadata.emplace_back("mapping_hash", g.mapping.hash);
  if (!g.out.report.time_zero.empty()) metadata.emplace_back("time_zero", g.out.report.time_zero);
  for (const auto& dropped : g.out.report.dropped)
    if (dropped.rows > 0)
      metadata.emplace_back("dropped", std::to_string(dropped.rows) + " rows: " + dropped.why);
}

void describe(ImportReport& report, const ImportMapping& mapping, const SourceTable& table,
              const RowReader& reader) {
  for (std::size_t i = 0; i < mapping.columns.size(); ++i) {
    const ColumnRule& rule = mapping.columns[i];
    auto& column = report.columns.emplace_back();
    column.source = table.names[reader.field_of(i)];
    column.unit = rule.unit;
    column.channel = rule.target == ColumnTarget::line    ? "line"
                     : rule.target == ColumnTarget::run   ? "run"
                     : rule.target == ColumnTarget::datum ? "datum"
                     : rule.target == ColumnTarget::zero  ? "zero"
                                                          : rule.channel.name();
  }
  const auto used = reader.used();
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i]) report.unused.push_back(table.names[i]);
  for (const auto& rule : mapping.drops) report.dropped.push_back({rule.why, 0, {}});
}

Result<void> check_metadata_of(const Gathering& g) {
  const auto slip = metadata_slip(g.out.dataset);
  if (!slip) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
              g.mapping.name + ": [metadata] " + g.out.dataset.metadata[slip->entry].first + ": " +
                  slip->sentence);
}

}  // namespace

Result<ImportedDataset> import_dataset(std::string_view bytes, const std::string& file_name,
                                       const ImportMapping& mapping) {
  const bool compressed = is_gzip(bytes);
  std::string inflated;
  if (compressed) {
    DRIFTWISE_TRY(auto text, gunzip(bytes, file_name, kMostImportBytes));
    inflated = std::move(text);
  }
  DRIFTWISE_TRY(const auto text,
                to_utf8(compressed ? inflated : bytes, mapping.file.encoding, file_name));

  ForeignRows rows(text, mapping.file.layout, file_name);
  SourceTable table;
  if (!read_names(rows, mapping.file.header, table)) {
    if (rows.error()) return tl::unexpected(*rows.error());
    return bad_table(reasons::kNoHeader, file_name, rows.line(),
                     "found no row of a table before the end of the file");
  }
  DRIFTWISE_TRY(const auto reader, RowReader::make(mapping, table, file_name));
  Gathering g{mapping, file_name, {}, {}, {}, {}};
  g.values.resize(mapping.columns.size());
  describe(g.out.report, mapping, table, reader);
  DRIFTWISE_RETURN_IF_ERROR(take_rows(g, rows, table, reader));
  if (mapping.time) {
    DRIFTWISE_TRY(auto ordered, g.times.put_in_order(*mapping.time, file_name));
    for (auto& values : g.values) values = in_order(values, ordered.rows);
    if (!g.validation.empty()) g.validation = in_order(g.validation, ordered.rows);
    g.out.dataset.time_s = std::move(ordered.time_s);
    g.out.report.late_rows = ordered.late;
    g.out.report.spread_rows = ordered.spread;
    if (mapping.time->format.has_epoch()) g.out.report.time_zero = to_iso8601(ordered.zero);
  }
  place_columns(g);
  for (const auto& pose : mapping.poses) apply_pose(pose, g.out.dataset);
  place_sets(g, place_groups(g));
  place_metadata(g, bytes);
  DRIFTWISE_RETURN_IF_ERROR(check_metadata_of(g));
  return std::move(g.out);
}

}  // namespace driftwise::formats
