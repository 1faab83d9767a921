#pragma once
// The frame in which the noise is independent. Robots are measured in pose coordinates. Where one
// motor moves one coordinate, the noise of a motor's discrepancy is that of its coordinate. A
// parallel robot has all coordinates in every motor through the slopes: a noisy tilt is in all six
// legs of a hexapod, and hides what acts on a length.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct CoordinateFrame {
  // Outputs: the pose coordinates, in the order of the data. Each is what the motors say of it
  // through the mean slopes, with what the baseline leaves of them through the row's own. Signs are
  // those of the motors.
  Problem problem;
  std::vector<ProblemOutput> motors;
  // One per row of the dataset: what the motors are off where the coordinates are off by one.
  // Motors x coordinates, summary units.
  std::vector<Eigen::MatrixXd> turn;
  // As the problem's outputs, by a fit to the rows that judge as well: rows x coordinates.
  Eigen::MatrixXd by_all_rows;

  // rows x coordinates of these rows of the dataset to rows x motors.
  Eigen::MatrixXd of_motors(const Eigen::MatrixXd& of_coordinates,
                            const std::vector<std::size_t>& rows) const;
};

// The baseline is the motors', fitted to all coordinates together: what it leaves of a row's motors
// is multiplied by the inverse of the row's slopes, and weighted by the coordinates' noise. Its
// columns stay in the fit of each coordinate.
//
// Nothing where the outputs are not as many motors as the baseline reads coordinates, where a row's
// slopes have no inverse, and where the motors' noise is as independent: 2 ln L of the coordinates,
// normal and independent, exceeds that of the motors by kFramesTold.
std::optional<CoordinateFrame> in_coordinates(const Problem& problem);

// For what is asked of all rows, held-out ones too: the frame's problem, as it is by now, with the
// baseline fitted to all of them. Without a frame the problem as it is.
Problem with_all_rows_fitted(Problem problem, const std::optional<CoordinateFrame>& frame);

// Far beyond the choice between two frames. Where one motor moves one coordinate it is 0.
inline constexpr double kFramesTold = 30;

}  // namespace driftwise::diagnosis
