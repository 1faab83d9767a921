#include "server/diagnosis/chance.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kScaleSd = 0.1, kHighestScale = 1.8;
constexpr double kPriceP = 1e-4;

// ln of 1 - (1 - g)^n for small g: the largest of n.
double ln_any_of(double ln_g, double ln_n) {
  const double ln_expected = ln_g + ln_n;
  if (ln_expected < -20) return ln_expected;
  const double g = std::exp(std::min(ln_g, 0.0));
  if (g >= 1) return 0;
  return std::log(-std::expm1(std::exp(ln_n) * std::log1p(-g)));
}

// ln n of the largest-of-n law that fits these ln g best: n = -S / sum ln(1 - g).
double fitted_ln_n(const std::vector<double>& ln_g, double most) {
  double sum = 0;
  for (const double one : ln_g) {
    const double g = std::exp(one);
    sum -= g < 1 - 1e-12 ? std::log1p(-g) : 27.6;
  }
  return std::log(std::clamp(static_cast<double>(ln_g.size()) / std::max(sum, 1e-12), 1.0,
                             std::max(most, 1.0)));
}

}  // namespace

double ln_chi2_upper(double x, double dof) {
  if (!(x > 0)) return 0;
  const double a = dof / 2, y = x / 2;
  if (y < 500) return std::log(boost::math::gamma_q(a, y));
  return -y + (a - 1) * std::log(y) - std::lgamma(a) + std::log1p((a - 1) / y);
}

double price_of(int dof) {
  return boost::math::quantile(boost::math::complement(
      boost::math::chi_squared_distribution<double>(std::max(dof, 1)), kPriceP));
}

NullTail::NullTail(const std::vector<double>& null_gains, int dof, std::size_t cells)
    : dof_(std::max(dof, 1)) {
  double highest = -INFINITY;
  for (double scale = 1; scale <= kHighestScale; scale += 0.05) {
    std::vector<double> ln_g;
    for (const double gain : null_gains) ln_g.push_back(ln_chi2_upper(gain / scale, dof_));
    const double ln_n = fitted_ln_n(ln_g, static_cast<double>(cells)), n = std::exp(ln_n);
    // density of the largest of n: n (1 - g)^(n - 1) f(gain), f the chi-squared density
    double likelihood = -std::pow((scale - 1) / kScaleSd, 2) / 2;
    for (std::size_t i = 0; i < ln_g.size(); ++i) {
      const double x = std::max(null_gains[i] / scale, 1e-6);
      const double g = std::min(std::exp(ln_g[i]), 1 - 1e-12);
      likelihood += ln_n + (n - 1) * std::log1p(-g) + (dof_ / 2.0 - 1) * std::log(x) - x / 2 -
                    std::log(scale);
    }
    if (likelihood <= highest) continue;
    highest = likelihood;
    scale_ = scale;
    ln_cells_ = ln_n;
  }
}

double NullTail::ln_p(double gain) const {
  return ln_any_of(ln_chi2_upper(gain / scale_, dof_), ln_cells_);
}

SearchTail::SearchTail(const std::vector<double>& null_smallest_ln_p, std::size_t causes)
    : ln_causes_(fitted_ln_n(null_smallest_ln_p, static_cast<double>(causes))) {}

double SearchTail::adjusted_p(double smallest_ln_p) const {
  return std::exp(ln_any_of(smallest_ln_p, ln_causes_));
}

}  // namespace driftwise::diagnosis
