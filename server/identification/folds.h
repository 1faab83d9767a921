#pragma once
// Which rows are held out together.

#include <cstddef>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::identification {

struct Fold {  // rows of the dataset, ascending
  std::vector<std::size_t> train, test;
};

// Contiguous blocks of equal numbers of rows; gap: the share of a block's rows that is left out of
// the training on either side of it, as calibration's own blocks of time. None below two blocks or
// three rows per block.
std::vector<Fold> time_folds(const std::vector<std::size_t>& rows, int blocks, double gap);

// A number per row of the dataset: rows with the same one belong together. by: "line", or channel
// symbols joined by commas ("goal_x,goal_y"): rows agree when all their values do. Errors:
// invalid_argument UNKNOWN_CHANNEL, NO_LINES.
Result<std::vector<int>> group_labels(const Dataset& dataset, const std::string& by);

// Whole groups, dealt to the folds in the order of their first row. None with fewer groups than
// folds or fewer than two folds.
std::vector<Fold> group_folds(const std::vector<std::size_t>& rows, const std::vector<int>& labels,
                              int folds);

}  // namespace driftwise::identification
