#pragma once
// Terms that the rows do not determine: of a force that took three values, the cube. Where all
// terms are in without selection (a diagnosis' baseline, an identification's linear terms), least
// squares would give such a term a coefficient that means nothing, and at other values it would be
// believed.

#include <Eigen/Core>
#include <vector>

namespace driftwise::calibration {

// columns: rows x k at the learning rows. Of each column whether less than 1e-4 of its variation is
// left beyond those before it. The first `kept` columns are never asked.
std::vector<char> undetermined(const Eigen::MatrixXd& columns, Eigen::Index kept);

}  // namespace driftwise::calibration
