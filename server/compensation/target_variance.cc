#include "server/compensation/target_variance.h"

#include <algorithm>
#include <cstdio>

#include "server/compensation/dot.h"
#include "server/compensation/geometry_law.h"
#include "server/core/reasons.h"
#include "server/core/units.h"

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

// Few roots are cheaper one by one than the form they make.
double line_variance(const Snapshot::UncertaintyLine& line, std::size_t size, const Basis& basis,
                     const double* squares) {
  double sum = line.variance_nm2.empty() ? 0 : variance(line.variance_nm2, squares);
  for (std::size_t row = 0; row + size <= line.roots_nm.size(); row += size) {
    const double error = dot(line.roots_nm.data() + row, basis.b.data(), size);
    sum += error * error;
  }
  return sum;
}

// In outputs' units; variances empty where they are not known.
double share_nm2(const Eigen::VectorXd& variances, std::size_t i) {
  return variances.size() == 0 ? 0 : variances[static_cast<Eigen::Index>(i)] * kNmPerMm * kNmPerMm;
}

// Part of a geometry's parameters in the squares of a line's errors, whose terms are in the line.
double systematic_nm2(const Snapshot& snapshot, const LawAnswer& law, std::size_t output,
                      const Snapshot::UncertaintyLine& line, const Basis& basis) {
  if (law.systematic.size() == 0) return 0;
  const auto& errors = snapshot.geometry->errors;
  const std::size_t size = snapshot.basis_size();
  double sum = 0;
  for (std::size_t row = 0; row < line.errors.size(); ++row)
    for (std::size_t e = 0; e < errors.size(); ++e) {
      if (errors[e].source != line.source || errors[e].number != line.errors[row]) continue;
      const double terms_nm = dot(line.roots_nm.data() + row * size, basis.b.data(), size);
      const double nm = kNmPerMm * law.systematic(static_cast<Eigen::Index>(output),
                                                  static_cast<Eigen::Index>(e));
      sum += nm * (nm + 2 * terms_nm);
    }
  return sum;
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
