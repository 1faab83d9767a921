#pragma once
// A dataset of runs as everybody who fits, diagnoses or exports sees it: the accepted points, with
// the corrections that are in force laid over them. The points in the store stay as they were.
// Called on the store's thread.

#include <optional>
#include <span>
#include <vector>

#include "server/core/ports/store.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

struct RunsData {
  Dataset data;
  std::vector<correction::RowOrigin> origins;  // one per row
  CellTime time_zero;  // what data.time_s counts from; utc_ns 0: an imported run
};

// Points of a run that are rows of its dataset, by id: all but those of a line that was measured
// again. limit: the first so many; 0: all. Errors: those of PointStore::points.
Result<std::vector<PointRecord>> points_in_dataset(Store& store, RunId run, std::size_t limit = 0);

// As it was measured; metadata: what its runs state together (core/data/stated_lines.h). Errors:
// those of RunStore::dataset, and METADATA_DISAGREE.
Result<RunsData> measured_data(Store& store, std::span<const RunId> runs);

// A correction holds where the instrument measured that it was found in: found in rows of a file,
// for the diagnosed runs alone; else for every run whose axis that device of the cell measured
// (instruments.h).
void confine(correction::DataAmendment& amendment, const std::vector<RunId>& runs);
// The change that a stored correction makes, confined. Errors: data_loss BAD_CORRECTION.
Result<correction::DataAmendment> amendment_of(Store& store, const CorrectionRecord& record);

// Corrections in the data of these runs, ascending: those in force that can change one of them, and
// what a join took into its rows, undone or not (corrections_in). Errors: data_loss BAD_CORRECTION.
Result<std::vector<CorrectionId>> corrections_over(Store& store, std::span<const RunId> runs);
// Changes of the corrections of these runs' data since an instant: "correction 3 came into
// force", "correction 1 was taken back"; empty: they are those of then. Errors: data_loss
// BAD_CORRECTION.
Result<std::vector<std::string>> corrections_since(Store& store, std::span<const RunId> runs,
                                                   CellTime since);

// With everything that is in force. Errors: those of both, and of correction::amend.
Result<RunsData> amended_data(Store& store, std::span<const RunId> runs);
Result<Dataset> amended_dataset(Store& store, std::span<const RunId> runs);
// The same as if this correction had not been accepted; none: amended_dataset().
Result<Dataset> dataset_without(Store& store, std::span<const RunId> runs,
                                std::optional<CorrectionId> correction);

}  // namespace driftwise::application
