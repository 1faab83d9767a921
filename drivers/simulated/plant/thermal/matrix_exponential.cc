#include "drivers/simulated/plant/thermal/matrix_exponential.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {
namespace {

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b,
                            std::size_t n) {
  std::vector<double> c(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const double factor = a[i * n + k];
      if (factor == 0) continue;
      for (std::size_t j = 0; j < n; ++j) c[i * n + j] += factor * b[k * n + j];
    }
  }
  return c;
}

}  // namespace

std::vector<double> matrix_exponential(std::vector<double> a, std::size_t n) {
  double norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double row = 0;
    for (std::size_t j = 0; j < n; ++j) row += std::abs(a[i * n + j]);
    norm = std::max(norm, row);
  }
  int squarings = 0;
  while (norm > 0.25) {
    norm /= 2;
    ++squarings;
  }
  for (double& value : a) value = std::ldexp(value, -squarings);

  std::vector<double> sum(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) sum[i * n + i] = 1;
  std::vector<double> term = sum;
  for (int k = 1; k <= 12; ++k) {  // 0.25^12 / 12! is below 1e-16
    term = product(term, a, n);
    for (double& value : term) value /= k;
    for (std::size_t i = 0; i < n * n; ++i) sum[i] += term[i];
  }
  for (; squarings > 0; --squarings) sum = product(sum, sum, n);
  return sum;
}

}  // namespace driftwise::simulated
