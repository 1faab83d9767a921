#pragma once
// What the best possible model of case B would reach: two oracles that look at the plant.

#include <cstddef>

#include "tests/statistics/case_b_campaign.h"

namespace driftwise::statistics {

// Knows the robot to the last digit: what the scales must read for every true pose, and the
// Jacobian. It fits to the calibration rows only what the instruments add: 1, x, y, z, time, rx,
// ry, rz. Nobody who has to find coefficients from the same rows can be expected to be as good. S90
// on the validation grid inside the forces, nm.
double robot_oracle_u90_nm(const CaseBCampaign& campaign, std::size_t axis);

// Knows which terms the robot has, and fits their coefficients to the same measured rows as
// everybody else. The terms are found on the robot without noise over all grids, going forward,
// until what they leave is below 3 nm (rms): powers of the pose to the 4th order, force to the 3rd,
// force and its square times powers of the pose, and the true temperature of every part of the
// robot, thermometer or none, also times powers of the pose.
struct TermsOracle {
  double u90_nm = 0;
  std::size_t terms = 0;
};
TermsOracle terms_oracle(const CaseBCampaign& campaign, std::size_t axis);

}  // namespace driftwise::statistics
