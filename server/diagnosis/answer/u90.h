#pragma once
// The figures that diagnoses state, of residuals: server/core/data/accuracy.h.

#include <Eigen/Core>

#include "server/core/data/accuracy.h"

namespace driftwise::diagnosis {

double u90_of(const Eigen::VectorXd& residuals);            // in their unit; NaN of fewer than two
ErrorFigures figures_of(const Eigen::VectorXd& residuals);  // all of them; rows without a value out

}  // namespace driftwise::diagnosis
