#pragma once
// The fast basis at one requested pose: what every answer of a snapshot begins with.

#include <array>

#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {

struct Basis {
  std::array<double, kMaxBasis> b;
};

// Column values of the request and the products made of them.
inline void fill_basis(const Snapshot& snapshot, const TargetRequest& request, Basis& basis) {
  std::array<double, kVariables> column;
  for (std::size_t v = 0; v < kVariables; ++v)
    column[v] = request.value[v] * snapshot.column_per_unit[v] + snapshot.column_shift[v];
  basis.b[0] = 1.0;
  for (std::size_t k = 0; k < snapshot.products.size(); ++k)
    basis.b[k + 1] = basis.b[snapshot.products[k].base] * column[snapshot.products[k].variable];
}

}  // namespace driftwise::compensation
