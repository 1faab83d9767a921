#pragma once
// The least-squares solution for a chosen set of terms, expanded back to their raw columns.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/calibration/linear/triangle.h"

namespace driftwise::calibration {

struct Solution {
  std::vector<int> columns;        // the terms, ascending: order of everything below
  Eigen::VectorXd coefficients;    // of the raw columns
  Eigen::MatrixXd root;            // covariance = rss / dof * root root'
  Eigen::MatrixXd shape;           // m x k: what least squares was done for, of scaled monomials
  Eigen::MatrixXd to_orthonormal;  // k x k: monomials shape to_orthonormal are orthonormal columns,
                                   // and coefficients = root times their products with y
  Eigen::VectorXd monomials;       // the same function as coefficients of the scaled monomials
  double rss = 0;
  int dof = 0;
  std::vector<int>
      deficient;  // of columns: what is left beyond those before it is below 1e-8 of it

  Eigen::MatrixXd covariance() const;
  double standard_error(Eigen::Index i) const;
};

// columns: indices into basis.expansions, each once. The work is done in the scaled monomials: raw
// columns = monomials * B, B = E T with T triangular over the terms' own monomials; least squares
// for E, then T^-1 in extended precision.
Solution solve(const Triangle& triangle, const Basis& basis, std::vector<int> columns,
               Eigen::Index output);

}  // namespace driftwise::calibration
