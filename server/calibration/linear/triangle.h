#pragma once
// What selection and the final solution need of the data: a small triangle instead of all rows.

#include <Eigen/Core>
#include <cstdint>

#include "server/calibration/design/basis.h"

namespace driftwise::calibration {

struct Triangle {
  Eigen::MatrixXd monomials;  // r x m: R of the monomials, upper trapezoid, r = min(rows, m)
  Eigen::MatrixXd outputs;    // r x o: Q'y of each output
  Eigen::VectorXd beyond;     // o: |y|^2 outside the span of all monomials
  Eigen::MatrixXd columns;    // r x terms: the raw columns in the same coordinates
  std::int64_t rows = 0;      // of data, with weight above 0
};

// joint: R of [1 | U | Y] about their means, (monomials + outputs) columns; means: what was taken
// off each column (the constant's is 0), put back here.
Triangle make_triangle(Eigen::MatrixXd joint, const Eigen::VectorXd& means, const Basis& basis,
                       Eigen::Index outputs, std::int64_t rows);

}  // namespace driftwise::calibration
