#pragma once
// The figure that diagnoses state: U90 = 1.645 standard deviations of residuals about their mean.

#include <Eigen/Core>

namespace driftwise::diagnosis {

double u90_of(const Eigen::VectorXd& residuals);  // in their unit; NaN of fewer than two

}  // namespace driftwise::diagnosis
