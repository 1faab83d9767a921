#pragma once
// Names of a dataset's rows for a person. Of runs: the run and the row of its plan, as `run points`
// shows it and `data exclude` takes it. The place in the dataset is another number, for passages
// and rows that were measured later stand in between.

#include <cstddef>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

// "row 14 of run 3". Of a passage: the row that its run measured next, or "the end of run 3".
// origins: one per row of the dataset, else the place counts: "row 17".
std::string row_name(const std::vector<correction::RowOrigin>& origins, const Dataset& data,
                     std::size_t row);

}  // namespace driftwise::application
