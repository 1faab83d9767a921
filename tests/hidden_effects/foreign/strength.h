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
//
// chi2 takes the cause's own column as exact. chi2_in_readings (readings.h) takes it from the file,
// with the true parameters and one free amplitude per pose coordinate j:
//
//   chi2_in_readings = sum_j g_j / (1 + (l_j + b_j) / f)
//   v   effect without noise, whitened by the true noise and cleared of the baseline of readings
//   c   column of the true cause from the readings, whitened and cleared likewise
//   g_j = (c_j v_j)^2 / |c_j|^2: RSS with the baseline less RSS with the baseline and c
//   l_j = |v_j|^2 - g_j: rest of the effect, which c does not follow
//   b_j   rest of (coefficient x error of reading) of the baseline's thermometers, beyond c
//   f     calibration rows less columns
//
// 1 + (l + b) / f is the variance that is left with the truth known, in that of the noise: a fit
// measures its gain against it. Exact readings give chi2. In a pair the other effect is known and
// subtracted.
//
// chi2_in_smoothed_readings: the largest of this and of fits in which thermometers are smoothed
// over the rows (Gaussian, 1 to 32 rows), the cause's and, as further columns, the baseline's.
// Without the latter a smoothed thermometer would gain from the reading noise of the others.
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
