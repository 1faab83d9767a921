#pragma once
// The triangle of a tall matrix: R of a Householder QR, by blocks of rows (TSQR). Q is never
// formed.

#include <Eigen/Core>
#include <vector>

#include "server/calibration/fit.h"

namespace driftwise::calibration {

// matrix: rows x width, any rows. Result: min(rows, width) x width, upper trapezoid; R'R = matrix'
// matrix. The blocks depend on the shape only, so the result is the same to the last bit for every
// executor.
Eigen::MatrixXd row_qr(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                       const Executor& executor = {});

// The triangle of all rows together, given those of its parts.
Eigen::MatrixXd join_triangles(const std::vector<Eigen::MatrixXd>& triangles);

}  // namespace driftwise::calibration
