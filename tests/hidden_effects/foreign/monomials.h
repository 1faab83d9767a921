#pragma once

#include <Eigen/Core>
#include <vector>

namespace driftwise::foreign {

// Exponents of all monomials of `variables` variables with total degree 1 .. degree.
std::vector<std::vector<int>> monomials(int variables, int degree);

double monomial_value(const std::vector<int>& powers, const Eigen::VectorXd& at);

}  // namespace driftwise::foreign
