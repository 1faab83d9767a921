#include "storage/datasets/dataset_import.h"

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "storage/rows/point_rows.h"
#include "storage/rows/run_rows.h"
#include "storage/watch/remark_store.h"

namespace driftwise::storage {
namespace {

void require_length(std::size_t found, const Dataset& dataset, const std::string& name) {
  if (found != dataset.rows)
    throw_failure(ErrorCode::invalid_argument, reasons::kBadDataset,
                  "column " + name + " has " + std::to_string(found) + " values, the dataset has " +
                      std::to_string(dataset.rows) + " rows: give one per row");
}

// The optional fields that the dataset has, as imported_file.fields names them.
std::string checked_fields(const Dataset& dataset) {
  std::string fields;
  const auto add = [&](const char* name, const auto& column) {
    if (column.empty()) return;
    require_length(column.size(), dataset, name);
    fields += (fields.empty() ? "" : " ") + std::string(name);
  };
  add("time_s", dataset.time_s);
  add("set", dataset.set);
  add("line", dataset.line);
  add("zero", dataset.zero);
  add("dwell_s", dataset.dwell_s);
  add("run", dataset.run);
  add("datum", dataset.datum);
  add("excluded", dataset.excluded);
  std::set<std::string> names;
  for (const DatasetColumn& column : dataset.columns) {
    require_length(column.values.size(), dataset, column.channel.name());
    if (!names.insert(column.channel.name()).second)
      throw_failure(ErrorCode::invalid_argument, reasons::kBadDataset,
                    "column " + column.channel.name() + " stands twice: name each channel once");
  }
  return fields;
}

void insert_file(Session& session, RunId run, const Dataset& dataset, const std::string& fields) {
  Query(session.db, "INSERT INTO imported_file (run_id, fields) VALUES (?, ?)")
      .bind(run.value, fields)
      .run();
  Query line(session.db,
             "INSERT INTO imported_metadata (run_id, position, key, value) VALUES (?, ?, ?, ?)");
  std::int64_t position = 0;
  for (const auto& [key, value] : dataset.metadata)
    line.bind(run.value, position++, key, value).run();
  Query column_row(session.db,
                   "INSERT INTO imported_column (run_id, position, channel_id) VALUES (?, ?, ?)");
  position = 0;
  for (const DatasetColumn& column : dataset.columns)
    column_row
        .bind(run.value, position++,
              session.names.channel(column.channel.name(), Names::Use::imported))
        .run();
}

Stamp instant_of(const Dataset& dataset, std::size_t row, Stamp created) {
  const double seconds = dataset.time_s.empty() ? static_cast<double>(row) : dataset.time_s[row];
  // A foreign file may count from anywhere; where that does not fit into 64 bits of ns, the row
  // number has to do.
  constexpr double kCenturyS = 3.2e9;
  const Nanoseconds since =
      nanoseconds_from_s(std::abs(seconds) < kCenturyS ? seconds : static_cast<double>(row));
  return {created.utc + since, created.monotonic_ns + since.count()};
}

}  // namespace

RunId import_rows(Session& session, const NewRun& run, const Dataset& dataset) {
  const std::string fields = checked_fields(dataset);
  NewRun with_rows = run;
  with_rows.rows = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (!is_passage(dataset, row)) ++with_rows.rows;
  // Passages are no points of the run: as in a measured one they count on after its rows.
  std::int64_t next_row = 0, next_passage = with_rows.rows;
  std::vector<std::int64_t> numbers;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    numbers.push_back(is_passage(dataset, row) ? next_passage++ : next_row++);
  const RunId id = insert_run(session, with_rows, RunState::done);
  insert_file(session, id, dataset, fields);

  // One datum per pair of run and datum that the file names.
  std::map<std::pair<std::int64_t, std::int64_t>, DatumId> datums;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    const Stamp measured = instant_of(dataset, row, run.created);
    const std::int64_t file_run = dataset.run.empty() ? 0 : dataset.run[row];
    const auto file_datum =
        dataset.datum.empty() ? std::nullopt : std::optional(dataset.datum[row]);
    auto& datum = datums[{file_run, file_datum.value_or(0)}];
    if (datum.value == 0)
      datum = insert_datum(
          session, {.id = {}, .run = id, .opened = measured, .reason = "imported", .values = {}},
          file_datum);

    PointRecord point;
    point.row = numbers[row];
    point.datum = datum;
    point.set = dataset.set_of(row);
    point.line = dataset.line.empty() ? 0 : dataset.line[row];
    point.zero = !dataset.zero.empty() && dataset.zero[row] != 0;
    point.passage = is_passage(dataset, row);
    point.measured = measured;
    point.dwell_s = dataset.dwell_s.empty() ? kMissing : dataset.dwell_s[row];
    for (const DatasetColumn& column : dataset.columns)
      if (!is_missing(column.values[row]))
        point.values.push_back({column.channel.name(), column.values[row]});
    insert_point(
        session, id, point,
        {.time_s = dataset.time_s.empty() ? std::nullopt : std::optional(dataset.time_s[row]),
         .run = dataset.run.empty() ? std::nullopt : std::optional(file_run)});
  }
  ExclusionRecord out{.id = 0,
                      .run = id,
                      .excluded = true,
                      .rows = {},
                      .reason = "excluded in the imported file",
                      .at = run.created,
                      .who = run.operator_name,
                      .from = ""};
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.is_excluded(row) && !is_suspect(dataset, row) && !is_passage(dataset, row))
      out.rows.push_back(numbers[row]);
  store_exclusion(session, out);
  out.rows.clear();
  out.reason = "suspect in the imported file";
  out.suspect = true;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (is_suspect(dataset, row)) out.rows.push_back(numbers[row]);
  store_exclusion(session, out);
  Query(session.db,
        "UPDATE run_progress SET reason = 'imported', next_row = ?2, accepted = ?2, started_ns = "
        "?3, ended_ns = ?3 "
        "WHERE run_id = ?1")
      .bind(id.value, with_rows.rows, run.created.utc.utc_ns)
      .run();
  return id;
}

}  // namespace driftwise::storage
