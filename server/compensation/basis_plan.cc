#include "server/compensation/basis_plan.h"

namespace driftwise::compensation {

std::size_t BasisPlan::index_of(const Exponents& exponents) {
  if (exponents == Exponents{}) return 0;
  if (const auto found = known_.find(exponents); found != known_.end()) return found->second;
  std::size_t last = kVariables - 1;
  while (exponents[last] == 0) --last;
  Exponents shorter = exponents;
  --shorter[last];
  const std::size_t base = index_of(shorter);
  products_.push_back({static_cast<std::uint16_t>(base), static_cast<std::uint8_t>(last)});
  needed_ |= bit(static_cast<Variable>(last));
  return known_[exponents] = products_.size();
}

void BasisPlan::evaluate(const std::array<double, kVariables>& values,
                         std::vector<double>& out) const {
  out.assign(size(), 1.0);
  for (std::size_t k = 0; k < products_.size(); ++k)
    out[k + 1] = out[products_[k].base] * values[products_[k].variable];
}

}  // namespace driftwise::compensation
