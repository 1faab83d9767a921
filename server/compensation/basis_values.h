#pragma once
// The fast terms at one requested pose: what every answer of a snapshot begins with.

#include <array>
#include <cstddef>

#include "server/compensation/dot.h"
#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {

struct Basis {
  std::array<double, kMaxBasis> b;
};

using Columns = std::array<double, kVariables>;

// Values of the request in the units and datum of the model's columns.
inline Columns columns_of(const Snapshot& snapshot, const std::array<double, kVariables>& request) {
  Columns column;
  for (std::size_t v = 0; v < kVariables; ++v)
    column[v] = request[v] * snapshot.column_per_unit[v] + snapshot.column_shift[v];
  return column;
}

// The products of column values.
inline void fill_basis(const Snapshot& snapshot, const Columns& columns, Basis& basis) {
  double* const b = basis.b.data();
  const double* const column = columns.data();
  const Snapshot::Product* const product = snapshot.products.data();
  const std::size_t count = snapshot.products.size();
  b[0] = 1.0;
  for (std::size_t k = 0; k < count; ++k)
    b[k + 1] = b[product[k].base] * column[product[k].variable];
}
inline void fill_basis(const Snapshot& snapshot, const TargetRequest& request, Basis& basis) {
  fill_basis(snapshot, columns_of(snapshot, request.value), basis);
}

// Slope of every product by one coordinate, per unit of the request. basis: filled at that place.
inline void fill_slope(const Snapshot& snapshot, const Columns& columns, const Basis& basis,
                       Variable by, Basis& slope) {
  const auto v = static_cast<std::uint8_t>(by);
  const double per_unit = snapshot.column_per_unit[v];
  double* const s = slope.b.data();
  const double* const b = basis.b.data();
  const double* const column = columns.data();
  const Snapshot::Product* const product = snapshot.products.data();
  const std::size_t count = snapshot.products.size();
  s[0] = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto [base, variable] = product[k];
    s[k + 1] = s[base] * column[variable] + (variable == v ? b[base] * per_unit : 0);
  }
}

// The terms of one pose, each worked out once: the products, and b b' packed as the variances are,
// so that every quadratic form of a target is one dot product. Large: one per thread of thought,
// handed down. Serves one pose and all models whose terms are the same.
class PoseTerms {
 public:
  // For the next pose, or a model with other terms.
  void clear() { has_basis_ = has_squares_ = false; }

  // The model has the terms of those before it since clear(), at the same pose.
  const Basis& basis(const Snapshot& snapshot, const std::array<double, kVariables>& pose) {
    if (!has_basis_) {
      columns_ = columns_of(snapshot, pose);
      fill_basis(snapshot, columns_, basis_);
      has_basis_ = true;
    }
    return basis_;
  }
  // After basis().
  const double* squares(const Snapshot& snapshot) {
    if (!has_squares_) {
      double* row = squares_.data();
      const double* const b = basis_.b.data();
      const std::size_t size = snapshot.basis_size();
      for (std::size_t i = 0; i < size; row += ++i) scale(b[i], b, row, i + 1);
      has_squares_ = true;
    }
    return squares_.data();
  }
  // After basis().
  void slope(const Snapshot& snapshot, Variable by, Basis& into) const {
    fill_slope(snapshot, columns_, basis_, by, into);
  }

 private:
  Basis basis_;
  Columns columns_;
  std::array<double, kMaxBasis*(kMaxBasis + 1) / 2> squares_;
  bool has_basis_ = false, has_squares_ = false;
};

// Two models whose terms have the same values at every pose.
bool have_same_terms(const Snapshot& a, const Snapshot& b);

}  // namespace driftwise::compensation
