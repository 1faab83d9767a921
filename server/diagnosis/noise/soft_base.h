#pragma once
// Columns of the present simulation: the baseline's, whose coefficients are free, and those of
// named causes, whose coefficients have a Gaussian prior about zero.

#include <Eigen/Core>
#include <random>

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
  // Of the columns with a prior the first so many are what readings hide: a series of noise has
  // them too.
  Eigen::Index hidden = 0;

  Eigen::Index free_count() const {
    Eigen::Index count = 0;
    while (count < columns.cols() && (precision.size() == 0 || precision[count] == 0)) ++count;
    return count;
  }
};

// Noise that readings hide, drawn from its prior: rows x outputs, in standard deviations of the
// white noise. Zero where nothing is hidden; nothing is drawn then.
Eigen::MatrixXd drawn_hidden(const SoftBase& base, Eigen::Index outputs, std::mt19937_64& random);

}  // namespace driftwise::diagnosis
