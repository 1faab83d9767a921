#include "tests/hidden_effects/foreign/monomials.h"

namespace driftwise::foreign {

std::vector<std::vector<int>> monomials(int variables, int degree) {
  std::vector<std::vector<int>> found;
  std::vector<int> powers(static_cast<std::size_t>(variables), 0);
  // Odometer over all exponents up to `degree`, keeping those of allowed total.
  for (;;) {
    int at = 0;
    while (at < variables && powers[at] == degree) {
      powers[at++] = 0;
    }
    if (at == variables) {
      return found;
    }
    ++powers[at];
    int total = 0;
    for (const int power : powers) {
      total += power;
    }
    if (total <= degree) {
      found.push_back(powers);
    }
  }
}

double monomial_value(const std::vector<int>& powers, const Eigen::VectorXd& at) {
  double value = 1.0;
  for (std::size_t j = 0; j < powers.size(); ++j) {
    for (int k = 0; k < powers[j]; ++k) {
      value *= at[static_cast<Eigen::Index>(j)];
    }
  }
  return value;
}

}  // namespace driftwise::foreign
