#pragma once

#include <cstddef>
#include <vector>

namespace driftwise::simulated {

// exp(a) of an n x n matrix, row by row, by scaling and squaring of the Taylor series (Moler & Van
// Loan 2003, method 3). For matrices like rate x step, whose norm is moderate: about 14 digits up
// to a norm of 100.
std::vector<double> matrix_exponential(std::vector<double> a, std::size_t n);

}  // namespace driftwise::simulated
