#pragma once
// The columns of every cell of every cause, worked out once: effects with memory run over all rows
// of the data, and only then are rows picked or averaged.

#include <vector>

#include "server/core/result.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/catalogue/physics.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {

// Every row of the dataset; a row that lacks a value counts as the column's mean: it says nothing
// for or against.
Result<Eigen::MatrixXd> filled_columns(const Problem& problem,
                                       const std::vector<effects::Term>& terms);

// The same, and products without what the simulation has of them: a search beside the simulation
// finds the same coefficients, and sees how long a column of the effect alone is.
Result<Eigen::MatrixXd> searched_columns(const Problem& problem,
                                         const std::vector<effects::Term>& terms);

// One per output: may the cause act there?
std::vector<char> acts_on(const Problem& problem, const Cause& cause);

// Cells of a cause that are one column as far as these data can tell (plays much narrower than
// every move) are taken out of the cause, but for the first. tick: as in ScanOptions.
// Errors: those of effects::TermEvaluator; cancelled.
Result<Bank> column_bank(const Problem& problem, const Physics& physics, std::vector<Cause>& causes,
                         const std::function<bool()>& tick);

}  // namespace driftwise::diagnosis
