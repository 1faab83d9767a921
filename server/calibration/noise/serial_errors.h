#pragma once
// Standard errors that allow for rows that are not independent: those of the same least-squares
// coefficients under the noise that noise_spectrum() expects.
//
// With Z orthonormal over the columns in and C the noise's covariance, cov(b) = R Z'C Z R' where
// the classical one is rss / dof R R'. A slow temperature loses most to slow noise, a position that
// is visited back and forth little or nothing: one factor for all, as from an effective number of
// rows, would be wrong for both.
//
// Up to 2048 rows all of them count, by restricted likelihood. Beyond, the noise is read from up to
// 16 stretches of 1024 rows spread evenly over the data, by the likelihood of the residuals alone,
// and so is the ratio of the two covariances: the cost then stays that of 16 384 rows.

#include "server/calibration/design/design.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/noise/noise_spectrum.h"
#include "server/calibration/noise/serial_noise.h"

namespace driftwise::calibration {

struct SerialErrors {
  SerialNoise noise;                // the best single slow part, as a description of the residuals
  NoiseSpectrum spectrum;           // what the errors below are under
  Eigen::VectorXd standard_errors;  // of solution.coefficients, same order
  Eigen::MatrixXd covariance;  // the same, whole: each error's factor on the classical one where
                               // not all rows were looked at
  Eigen::MatrixXd root;        // covariance = root root', without the square's loss of digits
};

// residuals: of the design's rows, in the output's unit. Without degrees of freedom: all 0.
SerialErrors serial_errors(const Design& design, const Solution& solution,
                           const Eigen::VectorXd& residuals);

}  // namespace driftwise::calibration
