#include "storage/datasets/dataset_rows.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "storage/watch/remark_store.h"

namespace driftwise::storage {
namespace {

void mark_excluded(Session& session, RunId run, std::vector<DatasetRow>& rows) {
  const auto out_rows = excluded_rows(session, run);
  std::map<std::int64_t, bool> out;  // point, suspect
  Query query(session.db, "SELECT point_id FROM point WHERE run_id = ? AND trajectory_row = ?");
  for (const auto& [number, excluded] : out_rows) {
    query.bind(run.value, number);
    while (query.row()) out[query.integer(0)] = excluded.suspect;
    query.restart();
  }
  for (DatasetRow& row : rows) {
    const auto found = out.find(row.point_id);
    row.suspect = found != out.end() && found->second;
    row.excluded = found != out.end() || row.passage;
  }
}

}  // namespace

std::vector<DatasetRow> read_dataset_rows(Session& session, RunId run) {
  Query query(
      session.db,
      "SELECT point_id, point.datum_id, measured_ns, point_set, line, is_zero, dwell_s, "
      "file_time_s, file_run, "
      "file_datum, EXISTS (SELECT 1 FROM passage WHERE passage.point_id = point.point_id) FROM "
      "point JOIN datum ON datum.datum_id = point.datum_id WHERE point.run_id = ? "
      "AND point_id NOT IN (SELECT point_id FROM repeated_point) ORDER BY point_id");
  query.bind(run.value);
  std::vector<DatasetRow> rows;
  while (query.row()) {
    DatasetRow row;
    row.point_id = query.integer(0);
    row.run = run.value;
    row.datum = query.integer(1);
    row.measured_ns = query.integer(2);
    row.set = query.text(3) == "validation" ? PointSet::validation : PointSet::calibration;
    row.line = query.integer(4);
    row.zero = query.integer(5) != 0;
    row.dwell_s = query.real(6);
    row.file_time_s = query.real(7);
    row.file_run = query.optional_integer(8);
    row.file_datum = query.optional_integer(9);
    row.passage = query.integer(10) != 0;
    rows.push_back(row);
  }
  mark_excluded(session, run, rows);
  return rows;
}

std::optional<std::string> imported_fields(Session& session, RunId run) {
  Query query(session.db, "SELECT fields FROM imported_file WHERE run_id = ?");
  return query.bind(run.value).row() ? std::optional(query.text(0)) : std::nullopt;
}

std::vector<DatasetRow> join_in_time(std::vector<std::vector<DatasetRow>> measured,
                                     std::vector<std::vector<DatasetRow>> imported) {
  std::vector<DatasetRow> all;
  for (auto& run : measured) all.insert(all.end(), run.begin(), run.end());
  std::ranges::sort(
      all, {}, [](const DatasetRow& row) { return std::tuple(row.measured_ns, row.point_id); });
  for (DatasetRow& row : all)
    row.time_s = static_cast<double>(row.measured_ns - all.front().measured_ns) /
                 1e9;  // correctly rounded, * 1e-9 is not

  for (auto& run : imported) {
    const double begin_s = all.empty() ? 0.0 : all.back().time_s + 1.0;
    const bool timed = std::ranges::none_of(
        run, [](const DatasetRow& row) { return is_missing(row.file_time_s); });
    for (std::size_t i = 0; i < run.size(); ++i)
      run[i].time_s =
          begin_s + (timed ? run[i].file_time_s - run.front().file_time_s : static_cast<double>(i));
    all.insert(all.end(), run.begin(), run.end());
  }
  return all;
}

}  // namespace driftwise::storage
