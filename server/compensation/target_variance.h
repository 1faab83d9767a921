#pragma once
// The variance of a target from an output's lines at one pose.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "server/compensation/basis_values.h"
#include "server/compensation/snapshot.h"
#include "server/core/result.h"

namespace driftwise::compensation {

// b' V b from the packed lower triangle with doubled off-diagonal entries, or a constant. squares:
// PoseTerms::squares.
double variance(const std::vector<double>& packed, const double* squares);

// All lines of an output together.
struct Variance {
  double nm2 = 0;
  double form_nm2 = 0;  // of it, what has no root
  bool known = true;    // false: the form is negative by more than rounding beside the rest
};
// terms: of this pose, whose basis is there.
Variance whole_variance(const Snapshot& snapshot, const Snapshot::Output& output,
                        const Basis& basis, PoseTerms& terms);

// Of one line, nm^2: its form and its roots.
double line_variance(const Snapshot::UncertaintyLine& line, std::size_t size, const Basis& basis,
                     const double* squares);
// Part of a geometry's parameters in the squares of a line's errors, whose terms are in the line.
struct LawAnswer;
double systematic_nm2(const Snapshot& snapshot, const LawAnswer& law, std::size_t output,
                      const Snapshot::UncertaintyLine& line, const Basis& basis);
// In outputs' units; variances empty where they are not known.
double share_nm2(const Eigen::VectorXd& variances, std::size_t output);

// failed_precondition DIGITS_LOST: of a model stored before, whose covariance has no root and too
// few digits.
Error lost_digits(const Snapshot& snapshot, const Snapshot::Output& output, double form_nm2);

}  // namespace driftwise::compensation
