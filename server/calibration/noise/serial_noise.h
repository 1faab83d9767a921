#pragma once
// How residuals in time order hang together: slow noise with exponential correlation plus white
// noise, the form that room and robot give them (NUMERICS.md section 3).
//
// covariance(i, j) = variance * (share * exp(-|i - j| / rows) for i != j, 1 for i = j). Rows count
// as equally spaced. Estimated by restricted maximum likelihood (Patterson and Thompson 1971),
// which gives back what the fitted terms took out of the residuals, with the likelihood of a series
// by the Kalman filter (Harvey 1989, section 3.4). Alternating residuals count as white,
// and so does noise that AIC finds no slow part in.

#include <Eigen/Core>

namespace driftwise::calibration {

struct SerialNoise {
  double variance = 0;  // of one row
  double share = 0;     // of the variance that is slow; 0: white
  double rows = 0;      // correlation length of the slow part
  double phi() const;   // correlation of the slow part from one row to the next
};

// columns: rows x terms, what was fitted, of full rank, well conditioned (orthonormal is best);
// without columns it is plain maximum likelihood. residuals: about those columns, in time order.
// Cost: about 80 passes of rows x terms^2.
SerialNoise serial_noise(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                         const Eigen::Ref<const Eigen::VectorXd>& residuals);

// What serial_noise() makes least: -2 x the restricted log likelihood at the best variance, less
// (rows - terms) (ln 2 pi + 1 - ln(rows - terms)).
double serial_deviance(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       const Eigen::Ref<const Eigen::VectorXd>& residuals, double share,
                       double correlation_rows);

// columns' C columns with C the correlation matrix of the noise; the identity's place is taken by
// columns' columns when the noise is white.
Eigen::MatrixXd correlated_gram(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                const SerialNoise& noise);

}  // namespace driftwise::calibration
