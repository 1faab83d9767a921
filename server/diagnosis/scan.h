#pragma once
// One pass of all causes over one or many series per output: for each cause its best cell and how
// much twice the log-likelihood grows with it. The data and the series simulated from their noise
// go through the same pass, so what the search over parameters, causes and shapes of noise does to
// chance is in both.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "server/calibration/executor.h"
#include "server/diagnosis/ground.h"

namespace driftwise::diagnosis {

// What is tried: cells side by side in one matrix.
struct Bank {
  struct Cell {
    Eigen::Index first = 0, count = 0;  // columns
  };
  struct Entry {                       // one cause
    std::size_t first = 0, count = 0;  // cells
    std::vector<char> on;              // one per output: does it act there?
  };
  Eigen::MatrixXd columns;  // at the rows of the search, finite
  std::vector<Cell> cells;
  std::vector<Entry> entries;
};

struct Best {
  double gain = 0;   // growth of 2 ln L, all outputs that the cause acts on together
  double score = 0;  // the same less the price of its degrees of freedom beyond the smallest cell's
  std::size_t cell = 0;  // within its cause
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

// Degrees of freedom that a cell may take at most, and of the smallest cell of an entry.
int dof_of(const Bank& bank, const Bank::Entry& entry, std::size_t cell);
int smallest_dof(const Bank& bank, const Bank::Entry& entry);

}  // namespace driftwise::diagnosis
