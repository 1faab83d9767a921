#pragma once
// Covariance of a least-squares solution over several outputs, whose noise differs in size and is
// not independent from row to row: J+ N J+', J+ the pseudo-inverse of the Jacobian and N the noise
// of each output as its own residuals show it (server/calibration/noise/noise_spectrum.h).
//
// The solution itself counts every output and every row alike. Numbers that all outputs share take
// a part of one direction only out of each: of an output's residuals the directions count as taken
// out that it lost most of, as many as it lost in sum.
//
// Beyond 2048 rows the noise is read from up to 16 stretches of 1024 rows, as serial_errors.h does.

#include <Eigen/Core>

namespace driftwise::identification {

// jacobian, residuals: all rows of the first output in time order, then of the second, ...; of full
// rank, with more rows than columns.
Eigen::MatrixXd serial_covariance(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
                                  Eigen::Index outputs);

}  // namespace driftwise::identification
