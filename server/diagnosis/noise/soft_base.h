#pragma once
// Columns of the present simulation: the baseline's, whose coefficients are free, and those of
// named causes, whose coefficients have a Gaussian prior about zero.

#include <Eigen/Core>

namespace driftwise::diagnosis {

struct SoftBase {
  SoftBase() = default;
  // All coefficients free.
  SoftBase(Eigen::MatrixXd free) : columns(std::move(free)) {}  // NOLINT: a base is its columns
  SoftBase(Eigen::MatrixXd all, Eigen::VectorXd precision_of)
      : columns(std::move(all)), precision(std::move(precision_of)) {}

  Eigen::MatrixXd columns;  // rows x k
  // One per column: (white noise's sd / prior sd)^2, in units of the column; 0: free. Empty: all
  // free. The free columns come first.
  Eigen::VectorXd precision;

  Eigen::Index free_count() const {
    Eigen::Index count = 0;
    while (count < columns.cols() && (precision.size() == 0 || precision[count] == 0)) ++count;
    return count;
  }
};

}  // namespace driftwise::diagnosis
