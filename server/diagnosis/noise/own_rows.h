#pragma once
// Error of each row by itself, beyond what its noise has in common with its neighbours' and
// beyond the simulation. In correlated noise whitened rows show a wrong reading in the row after it
// as well, and less of it in its own.

#include <Eigen/Core>
#include <vector>

#include "server/diagnosis/noise/whitened_space.h"

namespace driftwise::diagnosis {

struct OwnRows {
  // Of a column that is 1 in this row alone: its coefficient over its standard error, in units of
  // the noise. Rows x series.
  Eigen::MatrixXd off;
  // 1 over that standard error: off over it is in units of the series. 0: the simulation has a term
  // for that row.
  Eigen::VectorXd length;
};

// whitened: rows x series, what the space leaves of them. n rows cost n^2 times the columns of the
// simulation.
OwnRows own_rows(const WhitenedSpace& space, const Eigen::MatrixXd& whitened);

// Of rows that are far off, those that stay so by half beyond the farther ones; ascending.
std::vector<Eigen::Index> beyond_the_farther(const WhitenedSpace& space,
                                             const Eigen::Ref<const Eigen::VectorXd>& off,
                                             std::vector<Eigen::Index> rows);

}  // namespace driftwise::diagnosis
