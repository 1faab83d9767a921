#pragma once
// One pass of all causes over one or many series per output: for each cause the evidence for it,
// averaged over its cells, and its best cell. The data and the series simulated from their noise
// go through the same pass, so what the search over parameters, causes and shapes of noise does to
// chance is in both.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "server/calibration/model/executor.h"
#include "server/diagnosis/noise/ground.h"

namespace driftwise::diagnosis {

// What is tried: cells side by side in one matrix.
struct Bank {
  struct Cell {
    Eigen::Index first = 0, count = 0;  // columns
  };
  struct Entry {                       // one cause
    std::size_t first = 0, count = 0;  // cells
  };
  Eigen::MatrixXd columns;  // at the rows of the search, finite
  PriorSd prior;            // one row per column of `columns`
  std::vector<Cell> cells;
  std::vector<double> ln_weight;  // of each cell within its cause: its parameter's prior
  std::vector<Entry> entries;
};

struct Best {
  double evidence = -1e300;  // 2 ln of the marginal likelihood's ratio, averaged over the cells
  double gain = -1e300;      // of the best cell: 2 ln of the ratio at its parameter
  std::size_t cell = 0;      // within its cause
};

struct ScanOptions {
  const calibration::Executor& executor;
  std::function<bool()> tick;  // between slices of at most some tens of milliseconds; false: stop
};

// series[o]: rows x S, the same S for every output. allowed: one per entry. best[entry][series];
// empty: stopped.
std::vector<std::vector<Best>> scan(const Bank& bank, const Ground& ground,
                                    const std::vector<Eigen::MatrixXd>& series,
                                    const std::vector<char>& allowed, const ScanOptions& options);

}  // namespace driftwise::diagnosis
