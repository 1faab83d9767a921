#include "server/compensation/target_variance.h"

#include <algorithm>
#include <cstdio>

#include "server/core/reasons.h"

namespace driftwise::compensation {

double variance(const std::vector<double>& packed, const double* squares) {
  if (packed.size() == 1) return packed[0];
  return dot(packed.data(), squares, packed.size());
}

namespace {

// Sum of the squares of a triangle's rows times the basis.
double root_variance(const std::vector<double>& triangle, std::size_t size, const double* b) {
  double sum = 0;
  const double* row = triangle.data();
  for (std::size_t i = 0; i < size && !triangle.empty(); row += size - i, ++i) {
    const double error = dot(row, b + i, size - i);
    sum += error * error;
  }
  return sum;
}

}  // namespace

Variance whole_variance(const Snapshot& snapshot, const Snapshot::Output& output,
                        const Basis& basis, PoseTerms& terms) {
  constexpr double kRounding = 0.02;  // of the variance: 1 % of what is stated
  constexpr double kNothing_nm2 = 1e-6;
  Variance all{root_variance(output.root_nm, snapshot.basis_size(), basis.b.data())};
  if (output.variance_nm2.empty()) return all;
  all.form_nm2 = variance(output.variance_nm2,
                          output.variance_nm2.size() == 1 ? nullptr : terms.squares(snapshot));
  all.known = !(all.form_nm2 < -(kRounding * all.nm2 + kNothing_nm2));
  all.nm2 += std::max(0.0, all.form_nm2);
  return all;
}

Error lost_digits(const Snapshot& snapshot, const Snapshot::Output& output, double form_nm2) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", form_nm2);
  return {ErrorCode::failed_precondition, reasons::kDigitsLost,
          "the variance of " + output.channel.symbol + " that model " +
              std::to_string(snapshot.model.value) + " gives comes out as " + text +
              " nm^2: a coordinate lies far from zero beside its stroke, and the covariance of a "
              "model stored before has too few digits for that; fit it again and promote it, or "
              "ask without uncertainty"};
}

}  // namespace driftwise::compensation
