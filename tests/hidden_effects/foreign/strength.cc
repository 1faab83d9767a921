#include "tests/hidden_effects/foreign/strength.h"

#include <Eigen/QR>

#include "tests/hidden_effects/foreign/campaign.h"

namespace driftwise::foreign {

using Eigen::MatrixXd;

Whitened::Whitened(const Campaign& campaign, const MatrixXd& temperature) : campaign_(campaign) {
  const auto count = static_cast<Eigen::Index>(campaign.calibration.size());
  correlated_ = campaign.noise.correlated();
  if (correlated_) {
    factor_.compute(campaign.noise.covariance(campaign.time_s, campaign.calibration));
  } else {
    inverse_profile_.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      inverse_profile_[i] =
          1.0 / campaign.noise.profile[campaign.calibration[static_cast<std::size_t>(i)]];
    }
  }
  MatrixXd columns = whiten_columns(campaign.design(temperature));
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double size = columns.col(k).norm();
    if (size > 0.0) {
      columns.col(k) /= size;
    }
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  qr.setThreshold(1e-9);
  basis_ = qr.householderQ() * MatrixXd::Identity(count, qr.rank());
}

MatrixXd Whitened::whiten_columns(const MatrixXd& columns) const {
  const auto count = static_cast<Eigen::Index>(campaign_.calibration.size());
  MatrixXd chosen(count, columns.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    chosen.row(i) = columns.row(campaign_.calibration[static_cast<std::size_t>(i)]);
  }
  if (correlated_) {
    factor_.matrixL().solveInPlace(chosen);
  } else {
    chosen = inverse_profile_.asDiagonal() * chosen;
  }
  return chosen;
}

MatrixXd Whitened::clear_columns(const MatrixXd& columns) const {
  const MatrixXd white = whiten_columns(columns);
  const MatrixXd once = white - basis_ * (basis_.transpose() * white);
  return once - basis_ * (basis_.transpose() * once);
}

MatrixXd Whitened::clear(const MatrixXd& effect) const {
  return clear_columns(effect * campaign_.robot.sigma.cwiseInverse().asDiagonal());
}

}  // namespace driftwise::foreign
