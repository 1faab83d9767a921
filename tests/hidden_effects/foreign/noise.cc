#include "tests/hidden_effects/foreign/noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::foreign {
namespace {

using Eigen::VectorXd;

double typical_step_s(const VectorXd& time_s) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < time_s.size(); ++i) {
    steps.push_back(time_s[i] - time_s[i - 1]);
  }
  std::nth_element(steps.begin(), steps.begin() + static_cast<long>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

void set_unit_rms(VectorXd& profile) {
  profile /= std::sqrt(profile.squaredNorm() / static_cast<double>(profile.size()));
}

}  // namespace

const std::vector<std::string>& noise_kinds() {
  static const std::vector<std::string> kinds{
      "white",           "ar",         "ar_white",  "heavy_t3",
      "heteroscedastic", "one_over_f", "quantised", "day_night"};
  return kinds;
}

Noise make_noise(const std::string& kind, const VectorXd& time_s, const Eigen::MatrixXd& u,
                 Random& random) {
  Noise noise;
  noise.kind = kind;
  noise.profile = VectorXd::Ones(time_s.size());
  const double step_s = typical_step_s(time_s);
  const double longest_s = std::max((time_s[time_s.size() - 1] - time_s[0]) / 15.0, 2.0 * step_s);
  const auto add = [&](double variance, double tau_s) {
    noise.variances.push_back(variance);
    noise.taus_s.push_back(std::min(tau_s, longest_s));
    noise.white -= variance;
  };
  if (kind == "ar") {
    add(1.0, -step_s / std::log(random.uniform(0.3, 0.7)));
    noise.white = 0.0;
  } else if (kind == "ar_white") {
    add(random.uniform(0.3, 0.6), -step_s / std::log(random.uniform(0.75, 0.93)));
  } else if (kind == "heavy_t3") {
    noise.heavy = true;
  } else if (kind == "heteroscedastic") {
    // A beam in air: the spread grows with its length.
    const double share = random.uniform(0.5, 2.0);
    for (Eigen::Index i = 0; i < time_s.size(); ++i) {
      noise.profile[i] = 1.0 + share * 0.5 * (u(i, 0) + 1.0);
    }
    set_unit_rms(noise.profile);
  } else if (kind == "one_over_f") {
    // Equal variance per octave of time constants from one step to the longest.
    for (int k = 0; k < 5; ++k) {
      add(0.12, step_s * std::pow(longest_s / step_s, k / 4.0));
    }
  } else if (kind == "quantised") {
    noise.quantum = random.uniform(1.0, 2.5);
  } else if (kind == "day_night") {
    add(random.uniform(0.15, 0.3), longest_s);
    const double phase = random.uniform(0.0, 6.28);
    for (Eigen::Index i = 0; i < time_s.size(); ++i) {
      noise.profile[i] =
          1.0 + 0.35 * std::sin(2.0 * std::numbers::pi * time_s[i] / 86400.0 + phase);
    }
    set_unit_rms(noise.profile);
  }
  return noise;
}

VectorXd Noise::draw(const VectorXd& time_s, Random& random) const {
  VectorXd series(time_s.size());
  std::vector<double> state(variances.size());
  for (std::size_t k = 0; k < variances.size(); ++k) {
    state[k] = std::sqrt(variances[k]) * random.normal();
  }
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    double sum = std::sqrt(white) * (heavy ? random.student3() : random.normal());
    for (std::size_t k = 0; k < variances.size(); ++k) {
      if (i > 0) {
        const double keep = std::exp(-(time_s[i] - time_s[i - 1]) / taus_s[k]);
        state[k] =
            keep * state[k] + std::sqrt(variances[k] * (1.0 - keep * keep)) * random.normal();
      }
      sum += state[k];
    }
    series[i] = sum * profile[i];
  }
  return series;
}

Eigen::MatrixXd Noise::covariance(const VectorXd& time_s, const std::vector<int>& rows) const {
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int a = rows[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      const int b = rows[static_cast<std::size_t>(j)];
      double value = i == j ? white : 0.0;
      for (std::size_t k = 0; k < variances.size(); ++k) {
        value += variances[k] * std::exp(-std::abs(time_s[a] - time_s[b]) / taus_s[k]);
      }
      covariance(i, j) = covariance(j, i) = value * profile[a] * profile[b];
    }
  }
  return covariance;
}

double Noise::autocorrelation(double lag_s) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < variances.size(); ++k) {
    sum += variances[k] * std::exp(-lag_s / taus_s[k]);
  }
  return sum;
}

}  // namespace driftwise::foreign
