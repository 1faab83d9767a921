#pragma once
// Coefficients with standard errors that know the noise: generalised least squares over the blocks.

#include <Eigen/Core>

#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/soft_base.h"
#include "server/diagnosis/noise/white_sd.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Prior N(0, sd^2) of the added columns' amplitudes, against the white part of the noise.
struct AddedPrior {
  WhiteSd noise;
  Eigen::VectorXd sd;  // one per added column; 0: free; empty: all free
};

class WeightedFit {
 public:
  // base, added: blocks x k and blocks x c (c may be 0); of one output. Columns that are
  // combinations of those before them get coefficient 0 and error NaN.
  WeightedFit(const Problem& problem, const SoftBase& base, const Eigen::MatrixXd& added,
              std::size_t output, NoiseShape noise = {}, const AddedPrior& prior = {});

  // In the output's summary unit per unit of the column.
  double coefficient(Eigen::Index column) const { return coefficients_[column]; }
  double added_coefficient(Eigen::Index column) const { return coefficients_[base_ + column]; }
  double added_error(Eigen::Index column) const { return errors_[base_ + column]; }
  // Root mean square over rows of the standard error of columns times added coefficients.
  // columns: any rows x c. NaN where a coefficient is not determined.
  double added_spread(const Eigen::MatrixXd& columns) const;

 private:
  Eigen::Index base_ = 0;
  Eigen::VectorXd coefficients_, errors_;
  Eigen::MatrixXd root_;  // all columns x rank: its square is their covariance
};

}  // namespace driftwise::diagnosis
