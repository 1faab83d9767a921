#include "server/compensation/own_variance.h"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

namespace driftwise::compensation {

double own_variance(double scatter2, double noise2, double dof) {
  constexpr double kFewestDof = 5;
  constexpr double kNoNoise = 1e-12;  // of the scatter; also keeps the powers below within range
  if (!(noise2 > kNoNoise * scatter2) || !(scatter2 > 0) || dof < kFewestDof)
    return std::max(0.0, scatter2);
  // With r = noise sinh(y) the density of y is smooth, and wide where the ratio is large:
  // cosh(y)^(1 - dof) exp(-dof ratio / (2 cosh(y)^2)).
  const double ratio = scatter2 / noise2;
  const double peak = std::acosh(std::max(1.0, std::sqrt(ratio)));
  const auto log_density = [&](double y) {
    const double c = std::cosh(y);
    return (1 - dof) * std::log(c) - 0.5 * dof * ratio / (c * c);
  };
  const double top = log_density(peak);
  // Beyond this end the density is below 1e-14 of its largest: the flat top where s is about the
  // noise, and the tail, which falls as exp(y (3 - dof)).
  const double end = peak + 8 * std::pow(2 / dof, 0.25) + 40 / (dof - 3);
  const auto integral = [&](const auto& of) {
    using Rule = boost::math::quadrature::gauss_kronrod<double, 61>;
    constexpr unsigned kDepth = 12;
    constexpr double kTolerance = 1e-10;
    return (peak > 0 ? Rule::integrate(of, 0.0, peak, kDepth, kTolerance) : 0) +
           Rule::integrate(of, peak, end, kDepth, kTolerance);
  };
  const auto density = [&](double y) { return std::exp(log_density(y) - top); };
  const double whole = integral(density);
  const double squares = integral([&](double y) { return std::pow(std::sinh(y), 2) * density(y); });
  // Few degrees of freedom make the expectation of sigma^2 itself dof / (dof - 3) times s^2, with
  // and without noise. No line of the budget has that factor: they take s^2 for sigma^2.
  return (dof - 3) / dof * noise2 * squares / whole;
}

double variance_dof(const calibration::OutputModel& output) {
  const double share = output.accuracy.slow_share, rows = output.accuracy.slow_rows;
  if (!(share > 0) || !(rows > 0)) return output.dof;
  const double phi2 = std::exp(-2 / rows);
  return output.dof / (1 + 2 * share * share * phi2 / (1 - phi2));
}

}  // namespace driftwise::compensation
