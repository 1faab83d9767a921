#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/random.h"

namespace driftwise::foreign {

// Noise of unit variance: exponentially correlated parts and a white part, times a profile.
struct Noise {
  std::string kind;
  std::vector<double> variances;
  std::vector<double> taus_s;
  double white = 1.0;
  bool heavy = false;
  // Standard deviation of each row relative to the mean, rms 1 over the rows.
  Eigen::VectorXd profile;
  // Step of the reading in standard deviations of the analogue noise; 0 for none.
  double quantum = 0.0;

  // One series of independent innovations at these times.
  Eigen::VectorXd draw(const Eigen::VectorXd& time_s, Random& random) const;
  // Covariance over a choice of rows.
  Eigen::MatrixXd covariance(const Eigen::VectorXd& time_s, const std::vector<int>& rows) const;
  bool correlated() const { return !variances.empty(); }
  double autocorrelation(double lag_s) const;
};

const std::vector<std::string>& noise_kinds();

// Noise of a kind. u: poses (rows x coordinates) in [-1, 1], for noise that depends on the place.
Noise make_noise(const std::string& kind, const Eigen::VectorXd& time_s, const Eigen::MatrixXd& u,
                 Random& random);

}  // namespace driftwise::foreign
