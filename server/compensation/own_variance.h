#pragma once
// What a fit's residual holds beyond the noise of the instruments that saw it: the variance of the
// robot itself.
//
// The difference s^2 - noise^2 is no estimate of it where both are nearly equal: the scatter of s^2
// (chi-squared with the fit's degrees of freedom) makes it negative in one campaign and twice its
// size in the next, and what is cut off at 0 states that a robot adds nothing at all, which no
// number of rows can say. Taken instead is the expectation of r^2 given s^2, where s^2 is
// chi-squared about noise^2 + r^2, r is not negative, and nothing else is known of r: uniform in r
// (Gelman 2006, Prior distributions for variance parameters in hierarchical models, Bayesian
// Analysis 1, 515-534; uniform in r^2 is known to state too much). GUM Supplement 1 (JCGM 101:2008,
// 6.4.9) states a standard deviation of few readings in the same way. Where the noise is small the
// result is s^2 - noise^2.

#include <vector>

#include "server/calibration/model/model.h"

namespace driftwise::compensation {

// scatter2: s^2 of the residual; noise2: known variance of the instruments in it, same unit
// squared; dof: degrees of freedom of s^2. Without noise, and below 5 degrees of freedom, where the
// expectation says nothing, s^2 whole.
double own_variance(double scatter2, double noise2, double dof);

// Several outputs of one model: axes of one machine, built alike, so that what all of them show
// says something of each. The robot's standard deviations r_j are half-normal about a common scale
// t, which is itself unknown and uniform (Gelman 2006, sections 3.2 and 5; the hierarchical model
// of variance parameters). Where no output shows anything beyond the instruments, t is small and
// each is stated smaller than its own rows alone allow; where one shows much, t is large and the
// others are as by themselves. Result: E[r_j^2] given the scatter of all. One output: own_variance.
struct Scatter {
  double scatter2 = 0, noise2 = 0, dof = 0;  // as above
};
std::vector<double> own_variances(const std::vector<Scatter>& outputs);

// Degrees of freedom of a residual's variance where rows hang together: the variance of s^2 of a
// normal series is 2 sigma^4 / n times the sum of its squared autocorrelations (Bartlett 1946).
double variance_dof(const calibration::OutputModel& output);

}  // namespace driftwise::compensation
