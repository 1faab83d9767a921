#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace driftwise::foreign {

struct Campaign;

// Calibration rows of a campaign, whitened by the true noise and cleared of the stated baseline.
//
// Strength by the contract: chi2 = |v - P v|^2 / sigma^2, summed over the pose coordinates, which
// all have the same correlation in time and the same columns.
class Whitened {
 public:
  // temperature: readings that the baseline is given (rows x thermometers).
  Whitened(const Campaign& campaign, const Eigen::MatrixXd& temperature);

  // Effect on the pose (all rows x coordinates, mm or arcsec) as whitened, cleared, in sigma.
  Eigen::MatrixXd clear(const Eigen::MatrixXd& effect) const;
  // Columns (all rows x any), whitened and cleared.
  Eigen::MatrixXd clear_columns(const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd whiten_columns(const Eigen::MatrixXd& columns) const;
  double chi2(const Eigen::MatrixXd& effect) const { return clear(effect).squaredNorm(); }
  int parameters() const { return static_cast<int>(basis_.cols()); }

 private:
  const Campaign& campaign_;
  bool correlated_ = false;
  Eigen::VectorXd inverse_profile_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd basis_;
};

}  // namespace driftwise::foreign
