#pragma once
// Noise of a robot whose motors follow its pose differently from place to place.
//
// An instrument's noise is of the pose. In a motor's coordinate it is as large as that motor's
// slopes along the pose coordinates make it there: three times larger at one end of a hexapod's
// range than at the other, and at the other end for the next leg. Which share of the noise goes so,
// and which is the motors' own and the same everywhere, the data say.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct PoseNoise {
  Eigen::VectorXd of_row;  // standard deviation of all outputs together, every row; mean square 1
  Eigen::MatrixXd own;     // of each output over it, every row x outputs: Problem::own_sd
  // One coordinate's noise is in every motor, with other signs elsewhere: Problem::mixing.
  std::vector<Eigen::MatrixXd> mixing;
  double ratio = 1;        // of the largest to the smallest over the rows that learn, in the output
  std::size_t output = 0;  // where it is largest
};

// Nothing where the slopes are not known (Problem::slopes), where they are nearly the same
// everywhere, and where noise that is the same everywhere is as likely.
std::optional<PoseNoise> pose_noise(const Problem& problem);

}  // namespace driftwise::diagnosis
