#pragma once
// A published campaign of the simulated Micro-Nano, split by what only the plant knows: what the
// scales should have read, and what the instruments added.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "tests/support/micro_nano_campaign.h"

namespace driftwise::statistics {

struct CaseBCampaign {
  std::vector<testing_support::MicroNanoRow> rows;
  Dataset measured;  // as the cell exports it
  // By axis, mm: the reading that the robot would have given for the pose as *measured* (its true
  // answer, carried along the Jacobian), and the rest of q: noise of lengths, angles and scales.
  std::array<Eigen::VectorXd, 3> robot, instruments;
  std::vector<std::string> part_names;  // of the plant, in the order of rows[i].true_part_degc
};

CaseBCampaign case_b_campaign(std::uint64_t seed);

// 1.645 standard deviations, in nm, of the rows on the validation grid inside the forces (0.768 N).
double u90_inside_nm(const CaseBCampaign& campaign, const Eigen::VectorXd& errors_mm);

// y less its least squares by the columns and a constant, fitted to the calibration rows; all rows.
Eigen::VectorXd left_after_calibration(const CaseBCampaign& campaign,
                                       const Eigen::MatrixXd& columns, const Eigen::VectorXd& y);

}  // namespace driftwise::statistics
