#pragma once
// The triangle of a tall matrix from X'X (Cholesky), where that is safe.

#include <Eigen/Core>
#include <optional>

namespace driftwise::calibration {

// What must be left of a column beyond those before it, as a part of its own sum of squares, for
// X'X to be trusted: rounding, 2e-16, is then below 1e-11 of it. NUMERICS.md section 2 allows 1e-6;
// NIST's Filip, with 3e-5, keeps 11 digits there and is owed 13.
constexpr double kSafePivot = 1e-4;

struct GramTriangle {
  Eigen::MatrixXd joint;   // upper triangle, width x width; empty where it is not safe
  Eigen::Index worst = 0;  // the column with the smallest scaled pivot
  double worst_pivot = 1;
};

// gram: width x width, the lower triangle of [X | Y]'[X | Y]. The first `columns` of them, X, are
// held to kSafePivot. Of Y only what is left beyond X is kept, each output on its own row: products
// between outputs are dropped.
GramTriangle gram_triangle(const Eigen::MatrixXd& gram, Eigen::Index columns);

}  // namespace driftwise::calibration
