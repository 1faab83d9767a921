#include "server/compensation/own_variance.h"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>

namespace driftwise::compensation {

namespace {

constexpr double kFewestDof = 5;
constexpr double kNoNoise = 1e-12;  // of the scatter; also keeps the powers below within range

bool says_something(const Scatter& s) {
  return s.noise2 > kNoNoise * s.scatter2 && s.scatter2 > 0 && std::isfinite(s.scatter2) &&
         s.dof >= kFewestDof;
}

// Likelihood of one output on a grid of r, with the trapezoid's weights; r in nm or the like.
class Likelihood {
 public:
  explicit Likelihood(const Scatter& s) {
    // r = noise sinh(y), as in own_variance. The nodes crowd at y = 0, where the prior of a small
    // common scale is narrow; away from 0 they are even.
    const double ratio = s.scatter2 / s.noise2, noise = std::sqrt(s.noise2);
    const double peak = std::acosh(std::max(1.0, std::sqrt(ratio)));
    const double half = 8 * std::pow(2 / s.dof, 0.25);
    const double low = std::max(0.0, peak - half), high = peak + half + 40 / (s.dof - 3);
    double top = -std::numeric_limits<double>::infinity();
    std::vector<double> logs;
    for (int k = 0; k <= kNodes; ++k) {
      const double u = static_cast<double>(k) / kNodes;
      const double y = low > 0 ? low + u * (high - low) : high * u * u;
      const double dy = (low > 0 ? high - low : 2 * high * u) / kNodes;
      const double c = std::cosh(y), r = noise * std::sinh(y);
      r2_.push_back(r * r);
      weight_.push_back(noise * c * dy * (k == 0 || k == kNodes ? 0.5 : 1));
      logs.push_back(-s.dof * std::log(c) - 0.5 * s.dof * ratio / (c * c));
      top = std::max(top, logs.back());
    }
    for (std::size_t k = 0; k < logs.size(); ++k) weight_[k] *= std::exp(logs[k] - top);
    scale_ = std::max(noise * std::pow(2 / s.dof, 0.25), noise * std::sinh(peak));
    narrow_ = noise * std::pow(2 / s.dof, 0.25);
  }

  // Integral of the likelihood over r, half-normal about t; and of r^2 times it.
  struct Moments {
    double whole = 0, squares = 0;
  };
  Moments about(double t) const {
    Moments out;
    for (std::size_t k = 0; k < r2_.size(); ++k) {
      const double w = weight_[k] * std::exp(-0.5 * r2_[k] / (t * t));
      out.whole += w;
      out.squares += w * r2_[k];
    }
    out.whole /= t;
    out.squares /= t;
    return out;
  }
  double scale() const { return scale_; }    // largest r that it can show
  double narrow() const { return narrow_; }  // smallest

 private:
  static constexpr int kNodes = 400;
  std::vector<double> r2_, weight_;
  double scale_ = 0, narrow_ = 0;
};

}  // namespace

std::vector<double> own_variances(const std::vector<Scatter>& outputs) {
  std::vector<double> out;
  std::vector<std::size_t> joint;
  for (std::size_t j = 0; j < outputs.size(); ++j) {
    out.push_back(own_variance(outputs[j].scatter2, outputs[j].noise2, outputs[j].dof));
    if (says_something(outputs[j])) joint.push_back(j);
  }
  if (joint.size() < 2) return out;
  std::vector<Likelihood> likelihood;
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const auto j : joint) {
    likelihood.emplace_back(outputs[j]);
    low = std::min(low, likelihood.back().narrow());
    high = std::max(high, likelihood.back().scale());
  }
  // t on a logarithmic grid. Below and above, where the posterior falls as t and as t^(1 - m), a
  // thousandth of it is left out.
  constexpr int kScales = 120;
  low *= 0.01;
  high *= 100;
  const double step = std::pow(high / low, 1.0 / kScales);
  std::vector<double> squares(joint.size(), 0);
  double whole = 0;
  double unit = 0;  // keeps the products within range
  for (int k = 0; k <= kScales; ++k) {
    const double t = low * std::pow(step, k);
    double product = t;  // uniform in t: dt = t d(log t)
    std::vector<Likelihood::Moments> moments;
    for (const auto& one : likelihood) {
      moments.push_back(one.about(t));
      product *= moments.back().whole;
    }
    if (unit == 0 && product > 0) unit = product;
    if (unit == 0) continue;
    product /= unit;
    whole += product;
    for (std::size_t j = 0; j < joint.size(); ++j)
      if (moments[j].whole > 0) squares[j] += product * moments[j].squares / moments[j].whole;
  }
  if (!(whole > 0) || !std::isfinite(whole)) return out;
  for (std::size_t j = 0; j < joint.size(); ++j) {
    const double dof = outputs[joint[j]].dof;
    const double expected = (dof - 3) / dof * squares[j] / whole;
    if (std::isfinite(expected)) out[joint[j]] = expected;
  }
  return out;
}

double own_variance(double scatter2, double noise2, double dof) {
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
