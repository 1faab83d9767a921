#include "storage/datasets/dataset_query.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <unordered_map>

#include "server/core/data/row_marks.h"
#include "server/core/data/stated_lines.h"
#include "server/core/reasons.h"
#include "storage/datasets/dataset_columns.h"
#include "storage/datasets/dataset_rows.h"
#include "storage/rows/run_rows.h"

namespace driftwise::storage {
namespace {

void require_distinct(std::span<const RunId> runs) {
  std::set<std::int64_t> seen;
  for (const RunId run : runs)
    if (!seen.insert(run.value).second)
      throw_failure(
          ErrorCode::invalid_argument, reasons::kBadRuns,
          "run " + std::to_string(run.value) + " is named twice: a dataset takes each run once");
  if (runs.empty())
    throw_failure(ErrorCode::invalid_argument, reasons::kBadRuns,
                  "no run is named: a dataset is made of at least one");
}

bool has_field(std::string_view fields, std::string_view name) {
  for (std::size_t at = fields.find(name); at != std::string_view::npos;
       at = fields.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || fields[at - 1] == ' ') && (end == fields.size() || fields[end] == ' '))
      return true;
  }
  return false;
}

template <class T, class F>
void fill(std::vector<T>& column, const std::vector<DatasetRow>& rows, F&& value) {
  column.reserve(rows.size());
  for (const DatasetRow& row : rows) column.push_back(static_cast<T>(value(row)));
}

void fill_excluded(Dataset& dataset, const std::vector<DatasetRow>& rows, bool in_any_case) {
  if (in_any_case || std::ranges::any_of(rows, &DatasetRow::excluded))
    fill(dataset.excluded, rows, [](const auto& row) {
      return row.passage    ? kPassageRow
             : row.suspect  ? kSuspectRow
             : row.excluded ? kExcludedRow
                            : kInUse;
    });
}

// One imported run: the file as it was.
void fill_as_in_file(Dataset& dataset, const std::vector<DatasetRow>& rows,
                     std::string_view fields) {
  if (has_field(fields, "time_s"))
    fill(dataset.time_s, rows, [](const auto& row) { return row.file_time_s; });
  if (has_field(fields, "set")) fill(dataset.set, rows, [](const auto& row) { return row.set; });
  if (has_field(fields, "line")) fill(dataset.line, rows, [](const auto& row) { return row.line; });
  if (has_field(fields, "zero")) fill(dataset.zero, rows, [](const auto& row) { return row.zero; });
  if (has_field(fields, "dwell_s"))
    fill(dataset.dwell_s, rows, [](const auto& row) { return row.dwell_s; });
  if (has_field(fields, "run"))
    fill(dataset.run, rows, [](const auto& row) { return row.file_run.value_or(0); });
  if (has_field(fields, "datum"))
    fill(dataset.datum, rows, [](const auto& row) { return row.file_datum.value_or(0); });
  fill_excluded(dataset, rows, has_field(fields, "excluded"));
}

void fill_fields(Dataset& dataset, const std::vector<DatasetRow>& rows, bool several_runs) {
  fill(dataset.time_s, rows, [](const auto& row) { return row.time_s; });
  fill(dataset.set, rows, [](const auto& row) { return row.set; });
  fill(dataset.line, rows, [](const auto& row) { return row.line; });
  fill(dataset.zero, rows, [](const auto& row) { return row.zero; });
  fill(dataset.dwell_s, rows, [](const auto& row) { return row.dwell_s; });
  if (several_runs) fill(dataset.run, rows, [](const auto& row) { return row.run; });
  const bool one_datum =
      std::ranges::all_of(rows, [&](const auto& row) { return row.datum == rows.front().datum; });
  if (!one_datum) fill(dataset.datum, rows, [](const auto& row) { return row.datum; });
  fill_excluded(dataset, rows, false);
}

std::vector<std::pair<std::string, std::string>> metadata_in_file(Session& session, RunId run) {
  Query query(session.db,
              "SELECT key, value FROM imported_metadata WHERE run_id = ? ORDER BY position");
  query.bind(run.value);
  std::vector<std::pair<std::string, std::string>> lines;
  while (query.row()) lines.emplace_back(query.text(0), query.text(1));
  return lines;
}

std::vector<std::int64_t> columns_in_file(Session& session, RunId run) {
  Query query(session.db,
              "SELECT channel_id FROM imported_column WHERE run_id = ? ORDER BY position");
  query.bind(run.value);
  std::vector<std::int64_t> ids;
  while (query.row()) ids.push_back(query.integer(0));
  return ids;
}

Channel channel_of(Session& session, std::int64_t id) {
  auto channel = parse_robot_channel(session.names.channel_name(id));
  if (!channel) throw StorageFailure{channel.error()};
  return *std::move(channel);
}

// Of each column, the runs that have it, in the order in which they were named.
using RunsOfColumns = std::vector<std::vector<RunId>>;

// The first of these runs that is not among the others; the first of all where each is.
RunId run_apart(const std::vector<RunId>& runs, const std::vector<RunId>& others) {
  const auto apart = std::ranges::find_if(
      runs, [&others](const RunId run) { return std::ranges::find(others, run) == others.end(); });
  return apart == runs.end() ? runs.front() : *apart;
}

std::string unit_of_run(RunId run, const Channel& channel) {
  return "run " + std::to_string(run.value) + " gives " + channel.symbol + " in " + channel.unit;
}

// A fit takes one column of a symbol: rows of runs in another unit would be without a value. Runs
// that all measured the symbol in both units are left as they are.
void require_one_unit(const Dataset& dataset, const RunsOfColumns& runs_of) {
  std::unordered_map<std::string_view, std::size_t> first_of;  // by symbol
  for (std::size_t i = 0; i < dataset.columns.size(); ++i) {
    const Channel& channel = dataset.columns[i].channel;
    const std::size_t first = first_of.try_emplace(channel.symbol, i).first->second;
    if (runs_of[first] == runs_of[i]) continue;
    throw_failure(
        ErrorCode::invalid_argument, reasons::kUnitsDisagree,
        unit_of_run(run_apart(runs_of[first], runs_of[i]), dataset.columns[first].channel) + ", " +
            unit_of_run(run_apart(runs_of[i], runs_of[first]), channel) +
            ": expected each quantity in one unit of all runs that are taken together; import the "
            "file of one of them in the other's unit (a mapping file converts: docs/import.md), or "
            "name runs of one unit");
  }
}

// Values by columns; ids: the columns wanted, in order, none: every channel that the runs have.
// Errors: invalid_argument UNITS_DISAGREE (one symbol in two units, of different runs).
void read_columns(Session& session, std::span<const RunId> runs,
                  const std::vector<DatasetRow>& rows, const std::vector<std::int64_t>& ids,
                  Dataset& dataset) {
  std::unordered_map<std::int64_t, std::size_t> row_of;
  row_of.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) row_of[rows[i].point_id] = i;

  RunsOfColumns runs_of;
  std::unordered_map<std::int64_t, std::size_t> column_of;
  const auto column = [&](std::int64_t id) {
    const auto [found, is_new] = column_of.try_emplace(id, dataset.columns.size());
    if (is_new) {
      dataset.columns.push_back(
          {channel_of(session, id), std::vector<double>(rows.size(), kMissing)});
      runs_of.emplace_back();
    }
    return found->second;
  };
  for (const std::int64_t id : ids) column(id);

  Query query(
      session.db,
      "SELECT v.point_id, v.channel_id, v.value FROM point p CROSS JOIN point_value v "
      "ON v.point_id = p.point_id WHERE p.run_id = ? AND p.point_id NOT IN (SELECT point_id "
      "FROM repeated_point)");
  for (const RunId run : runs) {
    query.bind(run.value);
    std::int64_t point_id = 0;
    std::size_t row = 0;
    while (query.row()) {
      if (query.integer(0) != point_id) {  // a point's values follow one another
        point_id = query.integer(0);
        row = row_of.at(point_id);
      }
      const std::size_t at = column(query.integer(1));
      dataset.columns[at].values[row] = query.real(2);
      if (runs_of[at].empty() || runs_of[at].back() != run) runs_of[at].push_back(run);
    }
    query.restart();
  }
  if (runs.size() > 1) require_one_unit(dataset, runs_of);
}

void sort_columns(Dataset& dataset) {
  std::vector<Channel> order;
  for (const auto& column : dataset.columns) order.push_back(column.channel);
  sort_as_dataset(order);
  std::vector<DatasetColumn> sorted;
  for (const Channel& channel : order) {
    const auto found = std::ranges::find(dataset.columns, channel, &DatasetColumn::channel);
    sorted.push_back(std::move(*found));
  }
  dataset.columns = std::move(sorted);
}

}  // namespace

Dataset read_dataset(Session& session, std::span<const RunId> runs) {
  require_distinct(runs);
  std::vector<std::vector<DatasetRow>> measured, imported;
  std::vector<StatedLines> stated;
  std::optional<std::string> fields;
  for (const RunId run : runs) {
    require_run(session, run);
    fields = imported_fields(session, run);
    if (fields && runs.size() > 1) stated.push_back({{run}, metadata_in_file(session, run)});
    (fields ? imported : measured).push_back(read_dataset_rows(session, run));
  }

  Dataset dataset;
  if (runs.size() == 1 && fields) {
    dataset.rows = imported.front().size();
    fill_as_in_file(dataset, imported.front(), *fields);
    dataset.metadata = metadata_in_file(session, runs.front());
    read_columns(session, runs, imported.front(), columns_in_file(session, runs.front()), dataset);
    return dataset;
  }
  const std::vector<DatasetRow> rows = join_in_time(std::move(measured), std::move(imported));
  dataset.rows = rows.size();
  fill_fields(dataset, rows, runs.size() > 1);
  read_columns(session, runs, rows, {}, dataset);
  sort_columns(dataset);
  auto together = stated_together(dataset, stated);
  if (!together) throw StorageFailure{together.error()};
  dataset.metadata = *std::move(together);
  return dataset;
}

}  // namespace driftwise::storage
