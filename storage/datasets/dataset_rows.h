#pragma once
// The rows of a dataset before they become columns.

#include <optional>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/records/records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

struct DatasetRow {
  std::int64_t point_id = 0, run = 0, datum = 0, measured_ns = 0;
  PointSet set = PointSet::calibration;
  std::int64_t line = 0;
  bool zero = false;
  bool excluded = false, suspect = false, passage = false;
  double dwell_s = kMissing;
  double time_s = 0;              // in the dataset
  double file_time_s = kMissing;  // imported rows: as in the file
  std::optional<std::int64_t> file_run, file_datum;
};

// Accepted points of one run, in the order of its trajectory.
std::vector<DatasetRow> read_dataset_rows(Session& session, RunId run);

// Which of time_s, set, line, zero, dwell_s, run, datum, excluded an imported file had; none for a
// measured run.
std::optional<std::string> imported_fields(Session& session, RunId run);

// Puts the rows of several runs one after the other and sets time_s, which increases over all of
// them. Measured runs: by the instant of the point, from 0. Imported ones have no instants: each
// follows 1 s after what stands before it, with the file's own distances, or 1 s per row where the
// file has no time.
std::vector<DatasetRow> join_in_time(std::vector<std::vector<DatasetRow>> measured,
                                     std::vector<std::vector<DatasetRow>> imported);

}  // namespace driftwise::storage
